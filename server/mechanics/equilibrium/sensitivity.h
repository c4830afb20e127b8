// SPDX-License-Identifier: GPL-3.0-or-later
// How an equilibrium and its reactions answer to a change of parameters or of what is held: the
// implicit function theorem with the factor that the solver left behind (thesis (3.7), (4.9)).
//
//   F(x, p) = dPi/dx over what is free = 0      dx/dp = -(dF/dx)^-1 dF/dp
//   G(x, p) = dPi/dx over all nodes             dG/dp = dG/dx dx/dp + the partial one
//
//   auto change = sensitivity_by_parameter(solver, parameters, state);   // columns: parameters
//   auto heavier = sensitivity_by_load(solver, parameters, state, minus_weight_N);
//   Wrench w = reaction_change(clip, state.x, result.by_node, *change, column, about);
//   auto gradient = objective_by_parameter(solver, parameters, state, by_x, by_gradient);  //
//   adjoint
//
// Exact, also where nodes touch obstacles or elements are at an energy limit, as long as the set of
// those stays the same: their forces and multipliers answer too, instead of the soft constraint of
// (4.7) to (4.9). Costs one solve per column (adjoint: one in all), one per touching node and one
// per element at its limit. Requires solver.factor(): errors of kind `refused` where the last
// result was no checked minimum.
//
// Where laws remember their path (assembly/history/), what came before changes with the parameters
// too. With h the history at the start of a step and H at its end,
//
//   dx/dp = -(dF/dx)^-1 (dF/dp + dF/dh dh/dp)      dH/dp = H_x dx/dp + H_h dh/dp + H_p
//
//   Eigen::MatrixXd by_parameter = Eigen::MatrixXd::Zero(model.history_count(), columns);
//   for (each frame) {
//     solver.solve(parameters, loads, state, options, &history);
//     auto change = sensitivity_along_path(solver, parameters, state, only, by_parameter);
//     model.end_of_step(state.x, parameters, history, history.state);
//   }
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "server/mechanics/equilibrium/equilibrium.h"

namespace tenter::mechanics {

/// What moves an equilibrium besides parameters, column by column, 3 numbers a node. A matrix
/// without columns is none; where both have some, a column is one cause of both.
struct OuterChange {
  Eigen::MatrixXd load_N;  ///< of G at fixed positions: minus the change of the forces on nodes
  Eigen::MatrixXd held_m;  ///< displacements of held nodes and those in prescribed clips, else zero

  Eigen::Index count() const { return std::max(load_N.cols(), held_m.cols()); }
};

struct Sensitivity {
  Eigen::MatrixXd x;         ///< (3 nodes) x columns: dx, m per unit of the column's cause
  Eigen::MatrixXd gradient;  ///< the same size: dG, N per unit; zero where nodes are free
};

/// By every parameter of the model; or, where `only` is given, by those alone: one column each.
/// Then one a column of `outer`, with the same factor. A history stays as it is.
Expected<Sensitivity> sensitivity_by_parameter(EquilibriumSolver& solver,
                                               const Eigen::VectorXd& parameters,
                                               const State& state,
                                               const std::vector<Eigen::Index>* only = nullptr,
                                               const OuterChange* outer = nullptr);

/// The same through the whole path. `history_change`: dh/dp, history_count() rows and a column for
/// each of the result's, of the history that was passed to the solver; afterwards dH/dp.
/// Requires that history unchanged: `refused` where none was passed.
Expected<Sensitivity> sensitivity_along_path(EquilibriumSolver& solver,
                                             const Eigen::VectorXd& parameters, const State& state,
                                             const std::vector<Eigen::Index>* only,
                                             Eigen::MatrixXd& history_change,
                                             const OuterChange* outer = nullptr);

/// By forces that the model does not have: each column of `partial` is the change of G (N per unit,
/// over all nodes) at fixed x, of a term that is switched off, say.
Expected<Sensitivity> sensitivity_by_force(EquilibriumSolver& solver,
                                           const Eigen::VectorXd& parameters, const State& state,
                                           const Eigen::MatrixXd& partial);

/// By psi_max of an energy limit, one column: the density of its elements at the limit moves with
/// psi_max. Zero where none is there, or the model has no limit of this id.
Expected<Sensitivity> sensitivity_by_energy_max(EquilibriumSolver& solver,
                                                const Eigen::VectorXd& parameters,
                                                const State& state, const std::string& limit);

/// By displacements of what is held: each column moves nodes that are held or in prescribed clips
/// (m, 3 numbers a node; zero at all others).
Expected<Sensitivity> sensitivity_by_displacement(EquilibriumSolver& solver,
                                                  const Eigen::VectorXd& parameters,
                                                  const State& state,
                                                  const Eigen::MatrixXd& held_m);

/// By forces from outside: each column is what they add to G (N per unit), minus the forces
/// themselves. Of the weight of nodes by a factor on their masses: -m g.
Expected<Sensitivity> sensitivity_by_load(EquilibriumSolver& solver,
                                          const Eigen::VectorXd& parameters, const State& state,
                                          const Eigen::MatrixXd& load_N);

/// Change of reaction() with one column; `about_m` stays.
Wrench reaction_change(const Clip& clip, const Eigen::VectorXd& x, const Eigen::VectorXd& gradient,
                       const Sensitivity& change, int column, const Eigen::Vector3d& about_m);

/// dL/dp of an objective L(x, G), from its derivatives by positions and by the gradient G.
Expected<Eigen::VectorXd> objective_by_parameter(EquilibriumSolver& solver,
                                                 const Eigen::VectorXd& parameters,
                                                 const State& state, const Eigen::VectorXd& by_x,
                                                 const Eigen::VectorXd& by_gradient);

}  // namespace tenter::mechanics
