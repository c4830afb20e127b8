// SPDX-License-Identifier: GPL-3.0-or-later
// A step of what a mesh remembers, at positions that the parameters do not move: of terms that are
// switched off and only looked at, along the path of a sheet that goes its way without them.
//
//   G_k = d2E/dx dp + d2E/dx dh dh/dp        dH/dp = H_p + H_h dh/dp
//
// That is gradient_by_parameter, add_gradient_by_history, carry_history_change with dx = 0 and
// end_of_step in one: a law is asked once an element, where they ask it once a parameter and three
// times more.
//
//   Eigen::MatrixXd change = Eigen::MatrixXd::Zero(model.history_count(), columns.size());
//   for (each frame) {
//     history.duration_s = ...;
//     force.setZero(...);
//     status = take_held_step(model, x, parameters, columns, history, change, force);
//   }
//
// Exact; nothing allocates but the scratch of a column.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/mechanics/assembly/history/history.h"
#include "server/mechanics/assembly/mesh_model.h"

namespace tenter::mechanics {

/// Adds to `force` (3 nodes x columns) the derivatives of dE/dx by some parameters of terms that
/// remember; takes `change`, dh/dp of the same columns, and the history's state to the step's end.
/// Columns of other parameters stay as they are.
[[nodiscard]] AssemblyStatus take_held_step(const MeshModel& model, const Eigen::VectorXd& x,
                                            const Eigen::VectorXd& parameters,
                                            const std::vector<Eigen::Index>& columns,
                                            History& history, Eigen::MatrixXd& change,
                                            Eigen::MatrixXd& force);

}  // namespace tenter::mechanics
