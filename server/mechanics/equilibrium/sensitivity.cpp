// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/sensitivity.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tenter::mechanics {
namespace {

/// Solves with dF/dx: displacements of the nodes that answer to forces on them, where nodes that
/// touch an obstacle do not move against it and the energy of elements at their limit changes by
/// nothing but what parameters do to it. With N the normals of these conditions, c what N' dx shall
/// be, and K the factored stiffness (their penalties included, which then carry nothing),
///
///   K dx + N l = f     N' dx = c     l = (N' K^-1 N)^-1 (N' K^-1 f - c)
class Compliance {
 public:
  static Expected<Compliance> at(EquilibriumSolver& solver, const Eigen::VectorXd& parameters,
                                 const State& state) {
    if (!solver.factor())
      return fail(
          ErrorKind::refused,
          "there is no derivative: the last state was not found to be a stable equilibrium");
    ActiveLimits limits;
    if (solver.limits().multiplier.size() > 0 &&
        solver.model().active_limits(state.x, parameters, solver.limits(), limits) !=
            AssemblyStatus::ok)
      return fail(ErrorKind::refused, "a derivative of a limited energy is not finite");
    return Compliance(solver, state, std::move(limits));
  }

  /// Entries of MeshModel::limited() that are at their limit.
  const std::vector<int>& active_entries() const { return limits_.entry; }
  /// dpsi/dp of the elements at their limit.
  const Eigen::MatrixXd& limits_by_parameter() const { return limits_.by_parameter; }
  /// Their normals over all nodes.
  const Eigen::MatrixXd& limit_normals() const { return limits_.by_x; }

  /// Columns over all nodes, 3 numbers each. `limits_change`: c, one row an element at its limit.
  /// `multiplier`: l of the same.
  void solve(const Eigen::MatrixXd& force, const Eigen::MatrixXd& limits_change,
             Eigen::MatrixXd& displacement, Eigen::MatrixXd& multiplier) {
    const Unknowns& unknowns = solver_.unknowns();
    by_unknown_.resize(unknowns.count(), force.cols());
    Eigen::VectorXd column, moved;
    for (Eigen::Index k = 0; k < force.cols(); ++k) {
      unknowns.restrict_to(state_, force.col(k), column);
      by_unknown_.col(k) = column;
    }
    solver_.factor()->solve(by_unknown_.data(), by_unknown_.data(),
                            static_cast<int>(by_unknown_.cols()));
    const Eigen::Index limits = limits_change.rows();
    multiplier.resize(limits, force.cols());
    if (normals_.cols() > 0) {
      Eigen::MatrixXd along = normals_.transpose() * by_unknown_;
      along.bottomRows(limits) -= limits_change;
      const Eigen::MatrixXd held = conditions_->solve(along);
      by_unknown_ -= answers_ * held;
      multiplier = held.bottomRows(limits);
    }
    displacement.resize(force.rows(), force.cols());
    for (Eigen::Index k = 0; k < force.cols(); ++k) {
      column = by_unknown_.col(k);
      unknowns.expand(state_, column, moved);
      displacement.col(k) = moved;
    }
  }

 private:
  Compliance(EquilibriumSolver& solver, const State& state, ActiveLimits limits)
      : solver_(solver), state_(state), limits_(std::move(limits)) {
    const std::vector<Contact::Touch> touches = solver.contact().touches(state.x);
    if (limits_.entry.empty()) {  // none, but of the sizes that products with them have
      limits_.by_x.setZero(state.x.size(), 0);
      limits_.by_parameter.setZero(0, solver.model().parameter_count());
    }
    const auto touching = static_cast<Eigen::Index>(touches.size());
    const Eigen::Index count = touching + limits_.by_x.cols();
    if (count == 0) return;
    const Unknowns& unknowns = solver.unknowns();
    normals_.setZero(unknowns.count(), count);
    Eigen::VectorXd normal, column;
    for (Eigen::Index k = 0; k < count; ++k) {
      if (k < touching) {
        const Contact::Touch& touch = touches[static_cast<std::size_t>(k)];
        normal.setZero(state.x.size());
        normal.segment<3>(3 * static_cast<Eigen::Index>(touch.node)) = touch.normal;
      } else {
        normal = limits_.by_x.col(k - touching);
      }
      unknowns.restrict_to(state, normal, column);
      normals_.col(k) = column;
    }
    answers_.resize(unknowns.count(), count);
    solver.factor()->solve(normals_.data(), answers_.data(), static_cast<int>(count));
    conditions_.emplace(normals_.transpose() * answers_);
  }

  EquilibriumSolver& solver_;
  const State& state_;
  ActiveLimits limits_;
  Eigen::MatrixXd normals_, answers_;  ///< N, of touching nodes first, and K^-1 N
  std::optional<Eigen::LDLT<Eigen::MatrixXd>> conditions_;  ///< of N' K^-1 N
  Eigen::MatrixXd by_unknown_;
};

/// dx and dG from the change of G at fixed x of what is free, and of the limited energies.
Sensitivity answer(EquilibriumSolver& solver, Compliance& compliance,
                   const Eigen::MatrixXd& partial, const Eigen::MatrixXd& limits_change) {
  Sensitivity result;
  Eigen::MatrixXd multiplier;
  compliance.solve(-partial, limits_change, result.x, multiplier);
  // what obstacles bear changes with the state too: it is no force of the mesh on a holder
  std::vector<bool> is_held(static_cast<std::size_t>(partial.rows() / 3), true);
  for (const int node : solver.unknowns().free_nodes())
    is_held[static_cast<std::size_t>(node)] = false;
  result.gradient = partial;
  if (multiplier.rows() > 0) result.gradient.noalias() += compliance.limit_normals() * multiplier;
  solver.node_stiffness().multiply_add(result.x.data(), result.gradient.data(),
                                       static_cast<int>(partial.cols()), is_held);
  for (const int node : solver.unknowns().free_nodes())
    result.gradient.middleRows<3>(3 * static_cast<Eigen::Index>(node)).setZero();
  return result;
}

/// d2Pi/dx dp at fixed multipliers.
bool gradient_by_parameter(const EquilibriumSolver& solver, const Eigen::VectorXd& parameters,
                           const State& state, Eigen::MatrixXd& partial) {
  const EnergyLimitState* limits =
      solver.limits().multiplier.size() > 0 ? &solver.limits() : nullptr;
  return solver.model().gradient_by_parameter(state.x, parameters, partial, limits,
                                              solver.history()) == AssemblyStatus::ok;
}

/// By some parameters, then by what is outside. `history_change`: what both do to the start of the
/// step; null: nothing.
Expected<Sensitivity> by_all(EquilibriumSolver& solver, const Eigen::VectorXd& parameters,
                             const State& state, const std::vector<Eigen::Index>& columns,
                             const OuterChange& outer, const Eigen::MatrixXd* history_change) {
  auto compliance = Compliance::at(solver, parameters, state);
  if (!compliance) return tl::unexpected(compliance.error());
  const auto own = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index limits = compliance->limits_by_parameter().rows();
  Eigen::MatrixXd partial = Eigen::MatrixXd::Zero(state.x.size(), own + outer.count());
  Eigen::MatrixXd limits_change = Eigen::MatrixXd::Zero(limits, own + outer.count());
  if (partial.cols() == 0) return Sensitivity{partial, partial};
  if (own > 0) {
    Eigen::MatrixXd by_parameter;
    if (!gradient_by_parameter(solver, parameters, state, by_parameter))
      return fail(ErrorKind::refused, "a derivative by a parameter is not finite");
    partial.leftCols(own) = by_parameter(Eigen::indexing::all, columns);
    if (limits > 0)
      limits_change.leftCols(own) =
          -compliance->limits_by_parameter()(Eigen::indexing::all, columns);
  }
  if (outer.load_N.cols() > 0) partial.rightCols(outer.count()) = outer.load_N;
  for (Eigen::Index k = 0; k < outer.held_m.cols(); ++k)
    solver.node_stiffness().multiply_add(outer.held_m.col(k).data(), partial.col(own + k).data());
  if (outer.held_m.cols() > 0)
    limits_change.rightCols(outer.count()) -=
        compliance->limit_normals().transpose() * outer.held_m;
  if (history_change &&
      solver.model().add_gradient_by_history(state.x, parameters, *solver.history(),
                                             *history_change, partial) != AssemblyStatus::ok)
    return fail(ErrorKind::refused, "a derivative by the history is not finite");
  Sensitivity result = answer(solver, *compliance, partial, limits_change);
  if (outer.held_m.cols() > 0) result.x.rightCols(outer.count()) += outer.held_m;
  return result;
}

/// Of every parameter, or of some.
std::vector<Eigen::Index> columns_of(const MeshModel& model,
                                     const std::vector<Eigen::Index>* only) {
  if (only) return *only;
  std::vector<Eigen::Index> columns(static_cast<std::size_t>(model.parameter_count()));
  std::iota(columns.begin(), columns.end(), Eigen::Index{0});
  return columns;
}

}  // namespace

Expected<Sensitivity> sensitivity_by_parameter(EquilibriumSolver& solver,
                                               const Eigen::VectorXd& parameters,
                                               const State& state,
                                               const std::vector<Eigen::Index>* only,
                                               const OuterChange* outer) {
  return by_all(solver, parameters, state, columns_of(solver.model(), only),
                outer ? *outer : OuterChange{}, nullptr);
}

Expected<Sensitivity> sensitivity_along_path(EquilibriumSolver& solver,
                                             const Eigen::VectorXd& parameters, const State& state,
                                             const std::vector<Eigen::Index>* only,
                                             Eigen::MatrixXd& history_change,
                                             const OuterChange* outer) {
  const MeshModel& model = solver.model();
  std::vector<Eigen::Index> columns = columns_of(model, only);
  const OuterChange others = outer ? *outer : OuterChange{};
  const Eigen::Index count = static_cast<Eigen::Index>(columns.size()) + others.count();
  if (!solver.history())
    return fail(ErrorKind::refused, "the last state was solved for without a history");
  if (history_change.rows() != model.history_count() || history_change.cols() != count)
    return bad_input("the change of the history has " + std::to_string(history_change.rows()) +
                     " rows and " + std::to_string(history_change.cols()) + " columns instead of " +
                     std::to_string(model.history_count()) + " and " + std::to_string(count));
  auto result = by_all(solver, parameters, state, columns, others, &history_change);
  if (!result) return result;
  constexpr Eigen::Index kNoParameter = -1;
  columns.resize(static_cast<std::size_t>(count), kNoParameter);
  if (model.carry_history_change(state.x, parameters, *solver.history(), result->x, columns,
                                 history_change) != AssemblyStatus::ok)
    return fail(ErrorKind::refused, "a derivative of the history is not finite");
  return result;
}

Expected<Sensitivity> sensitivity_by_force(EquilibriumSolver& solver,
                                           const Eigen::VectorXd& parameters, const State& state,
                                           const Eigen::MatrixXd& partial) {
  if (partial.rows() != state.x.size())
    return bad_input("the change of the forces has " + std::to_string(partial.rows()) +
                     " rows instead of " + std::to_string(state.x.size()));
  auto compliance = Compliance::at(solver, parameters, state);
  if (!compliance) return tl::unexpected(compliance.error());
  return answer(solver, *compliance, partial,
                Eigen::MatrixXd::Zero(compliance->limit_normals().cols(), partial.cols()));
}

/// G at fixed x is left as it is: what the multipliers do to it is among the unknowns.
Expected<Sensitivity> sensitivity_by_energy_max(EquilibriumSolver& solver,
                                                const Eigen::VectorXd& parameters,
                                                const State& state, const std::string& limit) {
  auto compliance = Compliance::at(solver, parameters, state);
  if (!compliance) return tl::unexpected(compliance.error());
  const std::vector<int>& entries = compliance->active_entries();
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(entries.size()), 1);
  for (const LimitedElements& limited : solver.model().limited()) {
    if (limited.limit != limit) continue;
    const int end = limited.first + static_cast<int>(limited.element.size());
    for (std::size_t k = 0; k < entries.size(); ++k)
      if (entries[k] >= limited.first && entries[k] < end)
        change(static_cast<Eigen::Index>(k), 0) = 1.0;
  }
  return answer(solver, *compliance, Eigen::MatrixXd::Zero(state.x.size(), 1), change);
}

Expected<Sensitivity> sensitivity_by_displacement(EquilibriumSolver& solver,
                                                  const Eigen::VectorXd& parameters,
                                                  const State& state,
                                                  const Eigen::MatrixXd& held_m) {
  return by_all(solver, parameters, state, {}, {.load_N = {}, .held_m = held_m}, nullptr);
}

Expected<Sensitivity> sensitivity_by_load(EquilibriumSolver& solver,
                                          const Eigen::VectorXd& parameters, const State& state,
                                          const Eigen::MatrixXd& load_N) {
  return by_all(solver, parameters, state, {}, {.load_N = load_N, .held_m = {}}, nullptr);
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
  auto compliance = Compliance::at(solver, parameters, state);
  if (!compliance) return tl::unexpected(compliance.error());
  Eigen::MatrixXd partial;
  if (!gradient_by_parameter(solver, parameters, state, partial))
    return fail(ErrorKind::refused, "a derivative by a parameter is not finite");
  // G of free nodes stays zero and has no say
  Eigen::VectorXd held_gradient = by_gradient;
  for (const int node : solver.unknowns().free_nodes())
    held_gradient.segment<3>(3 * static_cast<Eigen::Index>(node)).setZero();
  Eigen::VectorXd weight = by_x;
  solver.node_stiffness().multiply_add(held_gradient.data(), weight.data());
  Eigen::MatrixXd adjoint, multiplier;
  compliance->solve(weight, compliance->limit_normals().transpose() * held_gradient, adjoint,
                    multiplier);
  Eigen::VectorXd result = partial.transpose() * (held_gradient - adjoint.col(0));
  if (multiplier.rows() > 0)
    result -= compliance->limits_by_parameter().transpose() * multiplier.col(0);
  return result;
}

}  // namespace tenter::mechanics
