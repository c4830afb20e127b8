// SPDX-License-Identifier: GPL-3.0-or-later
// Is the misfit the solver's own? One refined solve before any material is blamed (design,
// NUMERICAL).
//
// Three questions to a fitted model:
//   solver_tolerance  does chi2 fall when the fit goes on from where it stopped, with tolerances a
//                     thousand times finer and more iterations?
//   wrong_basin       does it fall when the fit starts elsewhere? Sixteen starts are drawn around
//                     the optimum (shape parameters within a decade, amplitudes within a factor of
//                     two), each improved by one Gauss-Newton step; the best is refitted
//   mesh_resolution   do the residuals move when the model follows every measured frame, with a
//                     midpoint between each two, instead of the thinned path of the fit?
//
// What moves by less than kShare of the lack of fit and of the noise is no finding: an effect must
// gain as much to be named (trial.h), so that less cannot be mistaken for one.
//
// Deterministic for a seed; costs about two fits and one evaluation on all frames.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

constexpr double kNumericalShare = 0.05;

struct RefinedSolve {
  double chi2 = 0.0;            ///< of the fit in question
  double expected_chi2 = 0.0;   ///< what noise alone would leave: rows less free parameters
  double continued_chi2 = 0.0;  ///< the same fit, gone on
  double restarted_chi2 = 0.0;  ///< from the best of the other starts; infinite where it failed
  double path_chi2 = 0.0;       ///< squared shift of the residuals on the finer path
  std::string effect;           ///< id of what was found, "" where the solve stands
  /// Takes the fit's place: better by more than kNumericalShare, or the end of a fit that had
  /// stopped early.
  std::optional<Reference> better;
  bool overfits = false;  ///< there was a better one, but it predicted left-out data worse

  /// What a movement must exceed.
  double threshold() const;
};

/// `whole`: every measured frame, with what the fit leaves out marked.
RefinedSolve refined_solve(const Reference& at, const DataPointer& data,
                           const estimation::DataSet& whole, unsigned long long seed,
                           const std::function<bool()>& keep_on);

/// Every measured frame of the diagnosis, without these readings.
estimation::DataSet whole_data(const Diagnosis& d,
                               const std::vector<estimation::Outlier>& left_out);

/// A line of the checklist with the figures. `whose`: "the baseline", "the extended model".
void check_refined_solve(Diagnosis& d, const RefinedSolve& solve, const std::string& whose);

/// NUMERICAL, for a baseline of which something was found.
Verdict numerical_verdict(const Diagnosis& d, const RefinedSolve& solve, unsigned long long seed);

}  // namespace tenter::diagnosis
