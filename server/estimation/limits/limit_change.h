// SPDX-License-Identifier: GPL-3.0-or-later
// How the residuals of sequences at rest change with Psi_max of an energy limit (thesis (4.5)).
//
//   dr/dPsi_max = (by_x . dx/dPsi_max + by_gradient . dG/dPsi_max) / sigma          (4.10)
//
// with dx and dG of sensitivity_by_energy_max: exact while the set of elements at their limit stays
// the same. Every frame is brought to rest once more, from where the evaluator left it: about the
// cost of an evaluation.
//
//   if (evaluator.evaluate(p, r, nullptr) == PathStatus::ok)
//     auto change = limit_change(evaluator, model, p, "lock", {.threads = 2});
#pragma once

#include <Eigen/Core>
#include <string>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/sequences/sequence_evaluator.h"

namespace tenter::estimation {

struct LimitChange {
  Eigen::VectorXd column;  ///< dr/dPsi_max: one a row, per J/m^2
  int active_frames = 0;   ///< with an element at the limit
  double largest = 0.0;    ///< Psi_i over all elements and frames, J/m^2
};

/// At the last evaluation of `evaluator`, which was of `parameters` under `model`. `refused` names
/// the frame that has no derivative.
Expected<LimitChange> limit_change(const SequenceEvaluator& evaluator, const model::Model& model,
                                   const Eigen::VectorXd& parameters, const std::string& limit,
                                   const SequenceOptions& options = {});

}  // namespace tenter::estimation
