// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "server/mechanics/equilibrium/lowest_mode.h"
#include "server/mechanics/equilibrium/option_check.h"

namespace tenter::mechanics {
namespace {

constexpr int kMostRounds = 60;  // of constraints
constexpr int kMostSaddles = 20;
constexpr double kNeutral = 1e-10;  // of the largest diagonal entry: less stiffness is rounding

bool has_pair(const NodeMatrix& matrix, int i, int j) {
  if (i < j) std::swap(i, j);
  const auto first = matrix.row().begin() + matrix.column_start()[static_cast<std::size_t>(j)];
  const auto last = matrix.row().begin() + matrix.column_start()[static_cast<std::size_t>(j) + 1];
  return std::binary_search(first, last, i);
}

Expected<void> check_options(const EquilibriumOptions& options) {
  using enum OptionRange;
  return check_numbers(
      {{"tolerance_N", options.tolerance_N, not_negative},
       {"max_iterations", static_cast<double>(options.max_iterations), not_negative},
       {"max_move_m", options.max_move_m, not_negative},
       {"contact_depth_m", options.contact_depth_m, positive},
       {"limit_tolerance", options.limit_tolerance, positive},
       {"contact_penalty_N_m", options.contact_penalty_N_m, not_negative}});
}

}  // namespace

std::string describe(const EquilibriumResult& result, const EquilibriumOptions& options) {
  std::string text = describe(result.last.end);
  if (result.stability == Stability::saddle)
    text += "; the state is a saddle: a motion lowers the energy";
  if (result.stability == Stability::neutral) text += "; a motion costs no energy";
  if (result.contact_violation_m > options.contact_depth_m)
    text += "; contact is not resolved to the depth asked for";
  if (result.limit_violation > options.limit_tolerance) text += "; an energy limit is exceeded";
  return text;
}

Expected<EquilibriumSolver> EquilibriumSolver::make(const MeshModel& model, Boundary boundary,
                                                    std::vector<Obstacle> obstacles) {
  if (auto ok = mechanics::check(boundary, model.node_count()); !ok)
    return tl::unexpected(ok.error());
  if (auto ok = mechanics::check(obstacles); !ok) return tl::unexpected(ok.error());
  const NodeMatrix matrix = model.matrix();
  for (const auto& t : boundary.pressed)
    for (std::size_t c = 0; c < 3; ++c)
      if (!has_pair(matrix, t[c], t[(c + 1) % 3]))
        return bad_input("the pressed surface has an edge from node " + std::to_string(t[c]) +
                         " to " + std::to_string(t[(c + 1) % 3]) + ", which no element has");
  EquilibriumSolver solver;
  solver.model_ = &model;
  solver.unknowns_ = std::make_shared<const Unknowns>(boundary, matrix);
  if (solver.unknowns_->count() == 0) return bad_input("every node is held: nothing is free");
  solver.boundary_ = std::move(boundary);
  solver.obstacles_ = std::move(obstacles);
  solver.factor_ = make_factor();
  solver.factor_->analyze(solver.unknowns_->pattern());
  return solver;
}

Expected<void> EquilibriumSolver::check_input(const Eigen::VectorXd& parameters, const Loads& loads,
                                              const State& state, const History* history) const {
  if (parameters.size() != model_->parameter_count())
    return bad_input("the model has " + std::to_string(model_->parameter_count()) +
                     " parameters, given are " + std::to_string(parameters.size()));
  if (!parameters.allFinite()) return bad_input("a parameter is no number");
  if (history)
    if (auto ok = mechanics::check(*history, model_->history_count()); !ok) return ok;
  if (auto ok = mechanics::check(state, boundary_, model_->node_count()); !ok) return ok;
  return mechanics::check(loads, boundary_, model_->node_count());
}

Expected<EquilibriumResult> EquilibriumSolver::solve(const Eigen::VectorXd& parameters,
                                                     const Loads& loads, State& state,
                                                     const EquilibriumOptions& options,
                                                     const History* history) {
  if (auto ok = check_input(parameters, loads, state, history); !ok)
    return tl::unexpected(ok.error());
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  place_clips(boundary_, state);
  const bool has_constraints = !obstacles_.empty() || model_->limited_count() > 0;
  const ConstraintTolerance tolerance{options.contact_depth_m, options.limit_tolerance};
  const Potential potential(*model_, parameters, boundary_, *unknowns_, loads, rounds_.contact(),
                            model_->limited_count() > 0 ? &rounds_.limits() : nullptr, history);
  history_ = history;
  bool is_near = options.start_is_near;
  if (has_constraints)
    start_constraints(potential, options, state);
  else if (is_near && options.predict)
    predict(potential, state);

  EquilibriumResult result;
  for (int round = 0; round <= kMostRounds; ++round) {
    EquilibriumOptions how = options;
    for (int saddle = 0; saddle <= kMostSaddles; ++saddle) {
      result.last = minimise(potential, how, is_near, state);
      result.iterations += result.last.iterations;
      result.factorisations += result.last.factorisations;
      result.evaluations += result.last.evaluations;
      result.stability = Stability::not_checked;
      if (!result.last.is_equilibrium()) break;
      if (options.reuse_factor && result.last.has_exact_factor) has_factor_ = true;
      if (has_factor_ || !options.check_minimum) break;
      result.stability = check(potential, state, result);
      if (result.stability != Stability::saddle || saddle == kMostSaddles) break;
      // a motion so soft that its force is below the tolerance: look closer
      if (saddle > 0 && result.last.iterations == 0) how.tolerance_N *= 0.1;
      if (!leave_saddle(potential, state)) {
        result.stability = Stability::neutral;  // what the motion gains is rounding
        break;
      }
      ++result.saddles_left;
      is_near = false;
    }
    is_near = has_factor_;
    if (!result.last.is_equilibrium() || !has_constraints) break;
    const Violation now = rounds_.violation(*model_, parameters, state.x);
    const Violation before{result.contact_violation_m, result.limit_violation};
    result.contact_violation_m = now.contact_m;
    result.limit_violation = now.limit;
    // without an energy there is nothing that another round could mend
    if (now.is_within(tolerance) || std::isinf(now.limit)) break;
    rounds_.press_harder(*model_, parameters, state.x, tolerance, before, now);
  }
  result.limit_multiplier = rounds_.limits().multiplier;
  if (state.x.allFinite()) result.contact_force_N = rounds_.contact().acting_forces_N(state.x);
  if (result.last.end == MinimiseEnd::start_not_finite) {
    result.energy_J = result.last.net_force_N = std::numeric_limits<double>::infinity();
  } else {
    result.energy_J = work_.current.energy_J;
    result.by_node = work_.current.by_node;
  }
  can_predict_ = has_factor_ || (!options.check_minimum && result.last.has_exact_factor);
  solved_ = state;
  return result;
}

/// Multipliers at zero, the contact's penalty on the scale of what it holds against.
void EquilibriumSolver::start_constraints(const Potential& potential,
                                          const EquilibriumOptions& options, const State& state) {
  rounds_.start(*model_, Contact());
  if (obstacles_.empty()) return;
  double penalty = options.contact_penalty_N_m;
  if (penalty <= 0.0 && potential.evaluate_with_stiffness(state, 1.0, work_.current))
    penalty = mean_diagonal(unknowns_->pattern(), work_.current.stiffness);
  rounds_.contact() = Contact(obstacles_, unknowns_->free_nodes(), penalty > 0.0 ? penalty : 1.0);
}

MinimiseResult EquilibriumSolver::minimise(const Potential& potential,
                                           const EquilibriumOptions& options, bool is_near,
                                           State& state) {
  has_factor_ = false;
  const MinimiseOptions how{options.tolerance_N, options.max_iterations, is_near,
                            options.max_move_m, options.reuse_factor};
  switch (options.minimiser) {
    case Minimiser::additive_lm:
      return minimise_by_additive_lm(potential, *factor_, how, state, work_);
    case Minimiser::relaxation:
      return minimise_by_relaxation(potential, how, state, work_);
    case Minimiser::newton:
      break;
  }
  return minimise_by_newton(potential, *factor_, how, state, work_);
}

/// One step from the last result with its factor: exact in what new parameters and loads do to the
/// forces there, linear in how far what is held has moved. (Further steps with the old factor were
/// tried: they rarely lower the net force.) Nothing is done where the start is not the last result.
void EquilibriumSolver::predict(const Potential& potential, State& state) {
  if (!can_predict_ || solved_.x.size() != state.x.size()) return;
  const Eigen::VectorXd held = state.x - solved_.x;
  for (const int node : unknowns_->free_nodes())
    if (!held.segment<3>(3 * node).isZero(0.0)) return;
  for (const Clip& clip : boundary_.clips)
    for (const int node : clip.nodes)
      if (clip.is_free && !held.segment<3>(3 * node).isZero(0.0)) return;
  if (!potential.evaluate(solved_, work_.trial)) return;
  work_.current.node_stiffness.multiply_add(held.data(), work_.trial.by_node.data());
  unknowns_->reduce_gradient(potential.loads, solved_, work_.trial.by_node, work_.trial.by_unknown);
  work_.step.resize(unknowns_->count());
  factor_->solve(work_.trial.by_unknown.data(), work_.step.data(), 1);
  work_.step = -work_.step;
  constexpr double kFar = 0.1;  // of the extent: a linear prediction is none there
  if (unknowns_->longest_move_m(work_.step) > kFar * extent_m(state.x)) return;
  work_.trial_state = state;
  unknowns_->move(work_.trial_state, work_.step, 1.0, state);
}

/// Whether some motion is so soft that its stiffness is rounding, or made by the net force that is
/// left (turning a body by its extent turns that force too). A singular matrix may pass as positive
/// definite; one solve shows it, from a fixed start with a part in every direction.
bool EquilibriumSolver::has_soft_motion(const State& state) {
  const SymmetricPattern& pattern = unknowns_->pattern();
  double largest = 0.0;
  for (int j = 0; j < pattern.size; ++j) {
    const auto first = static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j)]);
    largest = std::max(largest, work_.current.stiffness[first]);
  }
  Eigen::VectorXd& motion = work_.step;
  spread_start(pattern.size, motion);
  factor_->solve(motion.data(), motion.data(), 1);
  constexpr double kRounding = 1e-14;
  constexpr double kOfNetForce = 4.0;  // bodies are turned about a point within them
  const double soft_N_m =
      std::max(kRounding * largest, kOfNetForce * work_.current.net_force_N / extent_m(state.x));
  // what the start has of any one direction is about 1 / sqrt(size)
  return !(motion.norm() * std::sqrt(static_cast<double>(pattern.size)) * soft_N_m < 1.0);
}

/// Factorises the exact stiffness at `state`, which belongs to work_.current.
Stability EquilibriumSolver::check(const Potential& potential, const State& state,
                                   EquilibriumResult& result) {
  if (!work_.current.has_stiffness || work_.current.positive_share != 0.0) {
    ++result.evaluations;
    if (!potential.evaluate_with_stiffness(state, 0.0, work_.current)) return Stability::saddle;
  }
  ++result.factorisations;
  if (factor_->factorize(work_.current.stiffness.data()) == FactorStatus::ok) {
    has_factor_ = !has_soft_motion(state);
    return has_factor_ ? Stability::minimum : Stability::neutral;
  }
  const LowestMode mode = lowest_mode(unknowns_->pattern(), work_.current.stiffness, *factor_);
  lowest_mode_ = mode.direction;
  return mode.stiffness < -kNeutral * mode.largest_diagonal ? Stability::saddle
                                                            : Stability::neutral;
}

/// Goes down along the direction of least stiffness, as far as the energy falls; false where no
/// length of it lowers the energy.
bool EquilibriumSolver::leave_saddle(const Potential& potential, State& state) {
  const double longest = unknowns_->longest_move_m(lowest_mode_);
  if (!(longest > 0.0)) return false;
  double lowest = potential.energy_J(state);
  double best = 0.0;
  State there = state;
  constexpr double kLargest = 1e-2;  // of the extent
  constexpr double kSmallest = 1e-7;
  for (double part = kLargest; part >= kSmallest; part *= 0.25) {
    const double length = part * extent_m(state.x) / longest;
    for (const double signed_length : {length, -length}) {
      unknowns_->move(state, lowest_mode_, signed_length, there);
      const double energy = potential.energy_J(there);
      if (!(energy < lowest)) continue;
      lowest = energy;
      best = signed_length;
    }
    if (best != 0.0 && std::abs(best) > length) break;  // shorter ways fall less deep
  }
  if (best == 0.0) return false;
  unknowns_->move(state, lowest_mode_, best, there);
  state = there;
  return true;
}

}  // namespace tenter::mechanics
