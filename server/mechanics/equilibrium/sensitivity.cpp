// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/sensitivity.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

namespace tenter::mechanics {
namespace {

/// Solves with dF/dx: displacements of the nodes that answer to forces on them. Nodes that touch an
/// obstacle do not move against it: with N the normals and K the factored stiffness (penalties of
/// contact included, which then carry nothing),
///
///   dx = (I - K^-1 N (N' K^-1 N)^-1 N') K^-1 f
class Compliance {
 public:
  static Expected<Compliance> at(EquilibriumSolver& solver, const State& state) {
    if (!solver.factor())
      return fail(
          ErrorKind::refused,
          "there is no derivative: the last state was not found to be a stable equilibrium");
    if (solver.limits().multiplier.size() > 0 && solver.limits().multiplier.maxCoeff() > 0.0)
      return fail(ErrorKind::refused, "there is no derivative where an energy limit is active");
    return Compliance(solver, state);
  }

  /// Columns over all nodes, 3 numbers each; `displacement` has the size of `force`.
  void solve(const Eigen::MatrixXd& force, Eigen::MatrixXd& displacement) {
    const Unknowns& unknowns = solver_.unknowns();
    by_unknown_.resize(unknowns.count(), force.cols());
    Eigen::VectorXd column, moved;
    for (Eigen::Index k = 0; k < force.cols(); ++k) {
      unknowns.restrict_to(state_, force.col(k), column);
      by_unknown_.col(k) = column;
    }
    solver_.factor()->solve(by_unknown_.data(), by_unknown_.data(),
                            static_cast<int>(by_unknown_.cols()));
    if (normals_.cols() > 0)
      by_unknown_ -= answers_ * touching_.solve(normals_.transpose() * by_unknown_);
    displacement.resize(force.rows(), force.cols());
    for (Eigen::Index k = 0; k < force.cols(); ++k) {
      column = by_unknown_.col(k);
      unknowns.expand(state_, column, moved);
      displacement.col(k) = moved;
    }
  }

 private:
  Compliance(EquilibriumSolver& solver, const State& state) : solver_(solver), state_(state) {
    const std::vector<Contact::Touch> touches = solver.contact().touches(state.x);
    if (touches.empty()) return;
    const Unknowns& unknowns = solver.unknowns();
    const auto count = static_cast<Eigen::Index>(touches.size());
    normals_.setZero(unknowns.count(), count);
    Eigen::VectorXd normal, column;
    for (Eigen::Index k = 0; k < count; ++k) {
      const Contact::Touch& touch = touches[static_cast<std::size_t>(k)];
      normal.setZero(state.x.size());
      normal.segment<3>(3 * static_cast<Eigen::Index>(touch.node)) = touch.normal;
      unknowns.restrict_to(state, normal, column);
      normals_.col(k) = column;
    }
    answers_.resize(unknowns.count(), count);
    solver.factor()->solve(normals_.data(), answers_.data(), static_cast<int>(count));
    touching_.compute(normals_.transpose() * answers_);
  }

  EquilibriumSolver& solver_;
  const State& state_;
  Eigen::MatrixXd normals_, answers_;      ///< N and K^-1 N
  Eigen::LDLT<Eigen::MatrixXd> touching_;  ///< of N' K^-1 N
  Eigen::MatrixXd by_unknown_;
};

/// dx and dG from the change of G at fixed x of what is free.
Expected<Sensitivity> answer(EquilibriumSolver& solver, const State& state,
                             const Eigen::MatrixXd& partial, const Eigen::MatrixXd* held_m) {
  auto compliance = Compliance::at(solver, state);
  if (!compliance) return tl::unexpected(compliance.error());
  Sensitivity result;
  compliance->solve(-partial, result.x);
  // what obstacles bear changes with the state too: it is no force of the mesh on a holder
  std::vector<bool> is_held(static_cast<std::size_t>(partial.rows() / 3), true);
  for (const int node : solver.unknowns().free_nodes())
    is_held[static_cast<std::size_t>(node)] = false;
  result.gradient = partial;
  solver.node_stiffness().multiply_add(result.x.data(), result.gradient.data(),
                                       static_cast<int>(partial.cols()), is_held);
  for (const int node : solver.unknowns().free_nodes())
    result.gradient.middleRows<3>(3 * static_cast<Eigen::Index>(node)).setZero();
  if (held_m) result.x += *held_m;
  return result;
}

}  // namespace

Expected<Sensitivity> sensitivity_by_parameter(EquilibriumSolver& solver,
                                               const Eigen::VectorXd& parameters,
                                               const State& state) {
  Eigen::MatrixXd partial;
  if (solver.model().gradient_by_parameter(state.x, parameters, partial) != AssemblyStatus::ok)
    return fail(ErrorKind::refused, "a derivative by a parameter is not finite");
  return answer(solver, state, partial, nullptr);
}

Expected<Sensitivity> sensitivity_by_displacement(EquilibriumSolver& solver, const State& state,
                                                  const Eigen::MatrixXd& held_m) {
  Eigen::MatrixXd partial = Eigen::MatrixXd::Zero(held_m.rows(), held_m.cols());
  for (Eigen::Index k = 0; k < held_m.cols(); ++k)
    solver.node_stiffness().multiply_add(held_m.col(k).data(), partial.col(k).data());
  return answer(solver, state, partial, &held_m);
}

Wrench reaction_change(const Clip& clip, const Eigen::VectorXd& x, const Eigen::VectorXd& gradient,
                       const Sensitivity& change, int column, const Eigen::Vector3d& about_m) {
  Wrench wrench = reaction(clip, x, change.gradient.col(column), about_m);
  for (const int node : clip.nodes) {
    const auto first = 3 * static_cast<Eigen::Index>(node);
    const Eigen::Vector3d moved = change.x.col(column).segment<3>(first);
    const Eigen::Vector3d pull = -gradient.segment<3>(first);
    wrench.torque_N_m += moved.cross(pull);
  }
  return wrench;
}

Expected<Eigen::VectorXd> objective_by_parameter(EquilibriumSolver& solver,
                                                 const Eigen::VectorXd& parameters,
                                                 const State& state, const Eigen::VectorXd& by_x,
                                                 const Eigen::VectorXd& by_gradient) {
  auto compliance = Compliance::at(solver, state);
  if (!compliance) return tl::unexpected(compliance.error());
  Eigen::MatrixXd partial;
  if (solver.model().gradient_by_parameter(state.x, parameters, partial) != AssemblyStatus::ok)
    return fail(ErrorKind::refused, "a derivative by a parameter is not finite");
  // G of free nodes stays zero and has no say
  Eigen::VectorXd held_gradient = by_gradient;
  for (const int node : solver.unknowns().free_nodes())
    held_gradient.segment<3>(3 * static_cast<Eigen::Index>(node)).setZero();
  Eigen::VectorXd weight = by_x;
  solver.node_stiffness().multiply_add(held_gradient.data(), weight.data());
  Eigen::MatrixXd adjoint;
  compliance->solve(weight, adjoint);
  return Eigen::VectorXd(partial.transpose() * (held_gradient - adjoint.col(0)));
}

}  // namespace tenter::mechanics
