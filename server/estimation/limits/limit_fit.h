// SPDX-License-Identifier: GPL-3.0-or-later
// Psi_max of an energy limit and the elastic parameters, in alternation until both stop moving
// (thesis 4.4, finger benchmark), by output error on sequences at rest.
//
//   1. p       <- fit with Psi_max held
//   2. Psi_max <- least cost along Psi_max, with p following to first order:
//                 p + dp/dPsi_max d,   dp/dPsi_max = -(J'WJ)^-1 J'W g,   g = dr/dPsi_max
//
// Step 2 is a Gauss-Newton step in one number, halved until the cost falls; where it does not,
// smaller and smaller steps to both sides, for the cost has kinks in Psi_max. That p follows makes
// the alternation quick where a stiffness and the limit hang together, as they do where a pull ends
// at a known stretch. It begins at the better of the model's own Psi_max and some shares of the
// largest density that the data reach without the limit, for without an element at the limit there
// is no way to see which way to go.
//
// If the limit does not make the cost at least 3.84 w lower (profile.h) than without it, the data
// never reach it: Psi_max is then one-sided, at_least being where the cost has risen by 3.84 w.
//
//   auto found = fit_limit(model, sequences, "lock", {});
//   if (found->is_reached) ... found->energy_max, found->std_error
//   else ... found->at_least
//
// Deterministic, the same bytes for any number of threads. Costs some ten fits.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/estimation/fit.h"
#include "server/estimation/sequences/sequence_evaluator.h"

namespace tenter::estimation {

struct LimitFitOptions {
  SequenceOptions sequences;
  FitOptions fit;         ///< its weights and loss count in both steps
  int max_rounds = 20;    ///< of the alternation
  double settled = 0.02;  ///< both have stopped where neither moves by more standard errors
};

/// After step 1 of each round.
struct LimitRound {
  double energy_max = 0.0;
  double cost = 0.0;
  int iterations = 0;  ///< of the elastic fit
};

struct LimitFit {
  bool is_reached = false;  ///< the data determine Psi_max
  bool converged = false;   ///< of the alternation, or of the fit without limit
  bool stopped = false;     ///< by on_iteration
  std::string message;      ///< what the data say of the limit, in a sentence
  double energy_max = 0.0;  ///< Psi_max, J/m^2; where not reached, the largest density seen
  double std_error = 0.0;   ///< with all free parameters; zero where not reached
  /// Not zero: the slope still asks for so many standard errors of Psi_max, but no step lowers the
  /// cost, as where frames come to rest in other folds. Then not converged.
  double step_left = 0.0;
  std::optional<double> at_least;  ///< where not reached: end of the one-sided 95 % interval
  int active_frames = 0;
  double cost = 0.0, cost_without = 0.0;
  /// Of the elastic parameters, errors and correlations with Psi_max unknown too; where not
  /// reached, without the limit.
  FitResult elastic;
  /// Of Psi_max with each parameter.
  Eigen::VectorXd correlation;
  std::vector<LimitRound> rounds;
};

/// bad_input: the model has no such limit, or what SequenceEvaluator::make refuses. no result
/// (`refused`): no equilibrium could be fitted, with its reason.
Expected<LimitFit> fit_limit(const model::Model& model, const std::vector<Sequence>& sequences,
                             const std::string& limit, const LimitFitOptions& options = {});

}  // namespace tenter::estimation
