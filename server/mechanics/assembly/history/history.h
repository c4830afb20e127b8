// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh remembers of its path: the state of every path-dependent law (friction, plastic slip,
// viscosity, softening) on every element, at the start of a step.
//
//   h_(k+1) = H(x_(k+1), h_k, p)      E_k(x) = E(x, h_k, p)
//
// Within a step the laws have an incremental potential (law.h), so that E_k is an energy of x alone
// whose derivative is the force: equilibrium and implicit time steps minimise it as they do without
// history. Then the step is taken, and the next one starts from its end:
//
//   History history = model.never_strained();
//   for (each frame) {
//     history.duration_s = ...;                                  // where laws know time
//     auto result = solver.solve(parameters, loads, state, options, &history);
//     status = model.end_of_step(state.x, parameters, history, history.state);
//   }
//
// The path of a strain within a step is taken to be straight: frames, or steps between them, are as
// dense as reversals ask for. Derivatives by parameters are carried along by
// sensitivity_along_path (equilibrium/sensitivity.h).
//
// Data of the caller.
#pragma once

#include <Eigen/Core>

#include "common/base/error.h"

namespace tenter::mechanics {

struct History {
  /// MeshModel::history_count() numbers, in an order of the model's own; zero: never strained.
  Eigen::VectorXd state;
  double duration_s = 0.0;  ///< of the step that starts here
  /// What laws of the strain's rate measure it from, where that is not the start: a time step of
  /// second order (dynamics/time_scheme.h) has the rate (eps - rate_state)/rate_duration_s at its
  /// end. Duration 0: from the start.
  Eigen::VectorXd rate_state = {};
  double rate_duration_s = 0.0;
  /// Where the step is thought to end. While is_ahead, laws whose tangent jumps where the strain
  /// turns round answer with their linearisation at the strain they have there, energy, forces and
  /// stiffness (that of stresses as they are there): for the first look of a time step
  /// (dynamics/step.h).
  Eigen::VectorXd ahead = {};
  bool is_ahead = false;
};

/// bad_input where the state has another size, a number is none, or the duration is negative.
Expected<void> check(const History& history, int history_count);

}  // namespace tenter::mechanics
