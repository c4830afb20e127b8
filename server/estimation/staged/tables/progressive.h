// SPDX-License-Identifier: GPL-3.0-or-later
// The progressive fit of thesis 4.4: an energy that grows by one addend a step, each step started
// from the one before, and the rows of Table 4.1.
//
//   StVK          Psi = k/2 (e_u^2 + e_v^2) + lambda e_u e_v + mu/2 (w_u . w_v)^2, (4.3):
//                 k = lambda + 2 mu; bending with three stiffnesses (discrete shells)
//   A. Stretch    + a_u/2 e_u^2 + a_v/2 e_v^2
//   Nl. Stretch   a_u(e_u), a_v(e_v): curves
//   A. Shear      + a curve on w_u . w_v
//   Area Pres.    + an addend on the change of area J - 1
//   Cross-Modal   + a curve on the principal stretches
//
// All free numbers but the bending ones are lambda + mu, mu and the addends' stiffnesses, none
// negative: addends of one strain are convex by themselves, and so is their sum in the strains.
// From A. Shear on one number is one too many (a part of mu can stand in every addend): its
// standard error says nothing, those of the parameters do.
// Each step holds the one before as a special case: its parameters are a linear map of few free
// numbers (parameter_ties.h), and the new addend begins at nothing. A fit that ends at a higher
// cost (sheets that buckle have many rests) is left there, and the row says so.
//
//   auto rows = progressive_fit(training, held_out, options);
//   for (const ProgressiveRow& row : *rows) ... row.training.position_mm
//
// The objective is (4.6): positions and forces of all training sequences, each with its sigma.
// Pure; threads as in SequenceOptions.
#pragma once

#include "server/estimation/staged/stage.h"
#include "server/estimation/staged/tables/scenario_residual.h"

namespace tenter::estimation {

/// A model of the progression and how its parameters hang on the free numbers.
struct ProgressiveModel {
  std::string name;  ///< as in Table 4.1
  model::Model model;
  ParameterTies ties;
};

/// Strains that the training data reach, for the curves.
struct ProgressiveRanges {
  double stretch_u = 0.1, stretch_v = 0.1;        ///< from 0
  double shear = 0.3;                             ///< both ways
  double principal_lo = 0.0, principal_hi = 0.1;  ///< of both principal stretches less one
};
ProgressiveRanges progressive_ranges(const std::vector<std::vector<mechanics::State>>& states,
                                     const std::vector<RoleSequence>& sequences, double outliers);

constexpr int kProgressiveSteps = 6;
/// `before` is the model of the step before, fitted; null for the first.
ProgressiveModel progressive_model(int step, const ProgressiveRanges& ranges,
                                   const ProgressiveModel* before);

/// Root mean squares over all sequences of a table's cell.
struct PooledResidual {
  double position_mm = 0.0;
  double force_N = 0.0;
  int restless = 0;  ///< frames without a rest
};

struct ProgressiveRow {
  std::string name;
  model::Model model;
  double cost = 0.0;  ///< of the fit
  int iterations = 0;
  std::string message;
  int dropped = 0;  ///< frames that the fit left out: no rest at its start
  PooledResidual training;
  PooledResidual held_out;
};

/// bad_input as SequenceEvaluator::make(); refused where the first step finds no rest.
Expected<std::vector<ProgressiveRow>> progressive_fit(const std::vector<RoleSequence>& training,
                                                      const std::vector<RoleSequence>& held_out,
                                                      const StageOptions& options);

}  // namespace tenter::estimation
