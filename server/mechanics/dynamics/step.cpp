// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/dynamics/step.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/mechanics/equilibrium/option_check.h"

namespace tenter::mechanics {
namespace {

constexpr int kMostRounds = 60;  // of constraints

/// How much negative stiffness the next step leaves out at first, after one that began with
/// `first` and needed `last`: what had to be raised stays once.
double next_share(double first, double last) {
  constexpr double kDecay = 0.25, kLeast = 0.05;
  if (last > first) return last;
  return kDecay * last > kLeast ? kDecay * last : 0.0;
}

Expected<void> check_options(const StepOptions& options) {
  using enum OptionRange;
  return check_numbers(
      {{"tolerance_N", options.tolerance_N, not_negative},
       {"max_iterations", static_cast<double>(options.max_iterations), not_negative},
       {"contact_depth_m", options.contact_depth_m, positive},
       {"limit_tolerance", options.limit_tolerance, positive},
       {"largest_error_m", options.largest_error_m, not_negative},
       {"contact_penalty_N_m", options.contact_penalty_N_m, not_negative}});
}

}  // namespace

std::string describe(const StepResult& result, const StepOptions& options) {
  std::string text = describe(result.last.end);
  if (options.is_linearised && result.last.end == MinimiseEnd::converged)
    text = "one linearised step";
  if (result.violation.contact_m > options.contact_depth_m)
    text += "; contact is not resolved to the depth asked for";
  if (result.violation.limit > options.limit_tolerance) text += "; an energy limit is exceeded";
  if (options.largest_error_m > 0.0 && result.error_m > options.largest_error_m)
    text += "; its error is larger than asked for";
  return text;
}

Expected<TimeStepper> TimeStepper::make(const MeshModel& model, Boundary boundary,
                                        std::vector<Obstacle> obstacles) {
  if (auto ok = mechanics::check(boundary, model.node_count()); !ok)
    return tl::unexpected(ok.error());
  if (auto ok = mechanics::check(obstacles); !ok) return tl::unexpected(ok.error());
  TimeStepper stepper;
  stepper.model_ = &model;
  stepper.unknowns_ = std::make_shared<const Unknowns>(boundary, model.matrix());
  if (stepper.unknowns_->count() == 0) return bad_input("every node is held: nothing is free");
  stepper.boundary_ = std::move(boundary);
  stepper.obstacles_ = std::move(obstacles);
  stepper.factor_ = make_factor();
  stepper.factor_->analyze(stepper.unknowns_->pattern());
  return stepper;
}

Expected<void> TimeStepper::check_input(const Eigen::VectorXd& parameters, const StepInput& input,
                                        const Motion& motion, const StepOptions& options) const {
  if (parameters.size() != model_->parameter_count())
    return bad_input("the model has " + std::to_string(model_->parameter_count()) +
                     " parameters, given are " + std::to_string(parameters.size()));
  if (!parameters.allFinite()) return bad_input("a parameter is no number");
  if (auto ok = mechanics::check(motion.at, boundary_, model_->node_count()); !ok) return ok;
  const Eigen::Index points =
      motion.at.x.size() + 3 * static_cast<Eigen::Index>(boundary_.clips.size());
  const auto fits = [points](const Eigen::VectorXd& v) {
    return v.size() == points && v.allFinite();
  };
  if (!fits(motion.velocity_m_s) || (motion.last_step_s > 0.0 && (!fits(motion.last_points_m) ||
                                                                  !fits(motion.last_velocity_m_s))))
    return bad_input("the velocities must be three numbers a node and a clip: " +
                     std::to_string(points));
  if (!(input.duration_s > 0.0) || !std::isfinite(input.duration_s))
    return bad_input("a step of " + std::to_string(input.duration_s) + " s: it must be positive");
  if (!input.clips.empty()) {
    if (auto ok =
            mechanics::check(State{motion.at.x, input.clips}, boundary_, model_->node_count());
        !ok)
      return ok;
  }
  if (!input.obstacles.empty()) {
    if (input.obstacles.size() != obstacles_.size())
      return bad_input("the step has " + std::to_string(input.obstacles.size()) +
                       " obstacles, the stepper was made with " +
                       std::to_string(obstacles_.size()));
    if (auto ok = mechanics::check(input.obstacles); !ok) return ok;
  }
  if (input.loads.node_mass_kg.size() == 0)
    return bad_input("the loads have no masses: a motion needs them");
  if (motion.history.size() != 0)
    if (auto ok = mechanics::check(History{motion.history, 0.0, {}, 0.0}, model_->history_count());
        !ok)
      return ok;
  if (auto ok = check_options(options); !ok) return ok;
  if (options.is_linearised && added_.self_contact)
    return bad_input("a linearised step cannot keep a sheet from passing through itself");
  return mechanics::check(input.loads, boundary_, model_->node_count());
}

Expected<StepResult> TimeStepper::step(const Eigen::VectorXd& parameters, const StepInput& input,
                                       Motion& motion, const StepOptions& options) {
  if (auto ok = check_input(parameters, input, motion, options); !ok)
    return tl::unexpected(ok.error());
  start_step(options.scheme, boundary_, motion, input.duration_s, start_);
  if (!start_history(parameters, input.duration_s, motion))
    return fail(ErrorKind::refused, "what the material remembers of its start is no number");
  added_.inertia.set(boundary_, input.loads.node_mass_kg, start_);
  const Potential potential(
      *model_, parameters, boundary_, *unknowns_, input.loads, rounds_.contact(),
      model_->limited_count() > 0 ? &rounds_.limits() : nullptr, &history_, &added_);
  end_ = motion.at;
  for (std::size_t c = 0; c < input.clips.size(); ++c)
    if (!boundary_.clips[c].is_free) end_.clips[c] = input.clips[c];
  place_clips(boundary_, end_);
  StepResult result;
  result.order = start_.order;
  if (added_.longest_fraction(motion.at.x, end_.x) < 1.0) {
    result.last.end = MinimiseEnd::no_descent;  // the clips alone push the sheet through itself
    return result;
  }
  start_constraints(potential, input, options);
  if (options.is_linearised)
    result.last.end = solve_linearised(potential, motion.at, result);
  else
    solve(potential, options, result);
  if (!end_.x.allFinite()) return fail(ErrorKind::refused, "the step's result is not finite");
  if (!result.is_solved(options)) return result;
  report(potential, motion, result);
  if (!result.is_good(options)) return result;
  if (history_.state.size() > 0) {
    std::swap(motion.last_history, motion.history);
    if (model_->end_of_step(end_.x, parameters, history_, motion.history) != AssemblyStatus::ok)
      return fail(ErrorKind::refused, "what the material remembers of the step is no number");
  }
  finish_step(boundary_, start_, input.duration_s, end_, motion);
  return result;
}

bool TimeStepper::start_history(const Eigen::VectorXd& parameters, double duration_s,
                                Motion& motion) {
  has_path_ = false;
  if (model_->history_count() == 0) return true;
  if (motion.history.size() == 0) {
    if (model_->end_of_step(motion.at.x, parameters, model_->never_strained(), motion.history) !=
        AssemblyStatus::ok)
      return false;
    motion.last_history = motion.history;
  }
  history_.state = motion.history;
  history_.duration_s = duration_s;
  has_path_ = model_->turns_round() && motion.last_step_s > 0.0 &&
              motion.last_history.size() == motion.history.size();
  if (has_path_) {
    const double share = duration_s / motion.last_step_s;
    history_.ahead = (1.0 + share) * motion.history - share * motion.last_history;
  }
  history_.rate_duration_s = start_.last_share > 0.0 ? start_.h_s : 0.0;
  if (start_.last_share > 0.0)
    history_.rate_state =
        start_.now_share * motion.history - start_.last_share * motion.last_history;
  return true;
}

/// The multipliers of the step before, penalties on the scale of what they hold against.
void TimeStepper::start_constraints(const Potential& potential, const StepInput& input,
                                    const StepOptions& options) {
  if (!has_rounds_) {
    rounds_.start(*model_, Contact());
    has_rounds_ = true;
    if (!obstacles_.empty()) {
      penalty_N_m_ = options.contact_penalty_N_m;
      if (penalty_N_m_ <= 0.0 && potential.evaluate_with_stiffness(end_, 1.0, work_.current))
        penalty_N_m_ = mean_diagonal(unknowns_->pattern(), work_.current.stiffness);
      if (penalty_N_m_ <= 0.0) penalty_N_m_ = 1.0;
      rounds_.contact() = Contact(obstacles_, unknowns_->free_nodes(), penalty_N_m_);
    }
  }
  if (obstacles_.empty()) return;
  if (!input.obstacles.empty()) rounds_.contact().place(input.obstacles);
  rounds_.contact().set_penalty(penalty_N_m_);
}

void TimeStepper::solve(const Potential& potential, const StepOptions& options,
                        StepResult& result) {
  const bool has_constraints = !obstacles_.empty() || model_->limited_count() > 0;
  const ConstraintTolerance tolerance{options.contact_depth_m, options.limit_tolerance};
  // free nodes go on as they went, unless that costs more than to stay
  work_.trial_state = end_;
  for (const int node : unknowns_->free_nodes())
    work_.trial_state.x.segment<3>(3 * static_cast<Eigen::Index>(node)) =
        start_.begin_m.segment<3>(3 * static_cast<Eigen::Index>(node));
  double energy_J = potential.energy_J(end_);
  if (!take_if_lower(potential, energy_J) && added_.self_contact)
    added_.self_contact->begin(end_.x);
  result.evaluations += 2;
  if (has_path_) look_ahead(potential, energy_J, result);
  MinimiseOptions how;
  how.tolerance_N = options.tolerance_N;
  how.max_iterations = options.max_iterations;
  how.start_is_near = true;
  how.learn_secants = true;
  how.first_share = first_share_;
  for (int round = 0; round <= kMostRounds; ++round) {
    result.last = minimise_by_newton(potential, *factor_, how, end_, work_);
    if (result.last.factorisations > 0)
      first_share_ = next_share(how.first_share, result.last.share);
    result.iterations += result.last.iterations;
    result.factorisations += result.last.factorisations;
    result.evaluations += result.last.evaluations;
    if (!result.last.is_equilibrium() || !has_constraints) return;
    const Violation before = result.violation;
    result.violation = rounds_.violation(*model_, potential.parameters, end_.x);
    if (result.violation.is_within(tolerance) || std::isinf(result.violation.limit)) return;
    rounds_.press_harder(*model_, potential.parameters, end_.x, tolerance, before,
                         result.violation);
  }
}

// At the guess strains are off by many times what they change by in a step, which is nothing to an
// elastic law, but turns friction round. So the first step is one of a law without kinks: the
// linearisation of friction where the strains would be if they went on as they went.
void TimeStepper::look_ahead(const Potential& potential, double energy_J, StepResult& result) {
  PotentialValue& value = work_.current;
  history_.is_ahead = true;
  FactorStatus status = FactorStatus::not_positive_definite;
  const double first = ahead_share_;
  for (const double share : {first, 1.0}) {
    ++result.evaluations;
    if (!potential.evaluate_with_stiffness(end_, share, value)) break;
    ++result.factorisations;
    status = factor_->factorize(value.stiffness.data());
    ahead_share_ = next_share(first, share);
    if (status != FactorStatus::not_positive_definite) break;
  }
  history_.is_ahead = false;
  if (status != FactorStatus::ok) return;
  ++result.iterations;
  work_.step.resize(unknowns_->count());
  factor_->solve(value.by_unknown.data(), work_.step.data(), 1);
  work_.step = -work_.step;
  unknowns_->move(end_, work_.step, 1.0, work_.trial_state);
  ++result.evaluations;
  if (!take_if_lower(potential, energy_J) && added_.self_contact)
    added_.self_contact->begin(end_.x);
}

bool TimeStepper::take_if_lower(const Potential& potential, double& energy_J) {
  if (potential.longest_fraction(end_, work_.trial_state) < 1.0) return false;
  const double moved_J = potential.energy_J(work_.trial_state);
  if (!(moved_J < energy_J)) return false;
  std::swap(end_, work_.trial_state);
  energy_J = moved_J;
  return true;
}

/// One Newton step from the start of the step; what is prescribed moves the linear way.
MinimiseEnd TimeStepper::solve_linearised(const Potential& potential, const State& start,
                                          StepResult& result) {
  PotentialValue& value = work_.current;
  FactorStatus status = FactorStatus::not_positive_definite;
  const double first = linear_share_;
  for (const double share : {first, 1.0}) {
    ++result.evaluations;
    if (!potential.evaluate_with_stiffness(start, share, value))
      return MinimiseEnd::start_not_finite;
    ++result.factorisations;
    status = factor_->factorize(value.stiffness.data());
    linear_share_ = next_share(first, share);
    if (status != FactorStatus::not_positive_definite) break;
  }
  if (status == FactorStatus::out_of_memory) return MinimiseEnd::out_of_memory;
  if (status != FactorStatus::ok) return MinimiseEnd::no_descent;
  ++result.iterations;
  work_.sum = end_.x - start.x;
  if (!work_.sum.isZero(0.0)) {
    value.node_stiffness.multiply_add(work_.sum.data(), value.by_node.data());
    unknowns_->reduce_gradient(potential.loads, start, value.by_node, value.by_unknown);
    for (const ClipSpring& spring : added_.clip_springs())
      unknowns_->add_spring_gradient(spring, start, value.by_unknown);
  }
  work_.step.resize(unknowns_->count());
  factor_->solve(value.by_unknown.data(), work_.step.data(), 1);
  work_.step = -work_.step;
  work_.trial_state = end_;
  unknowns_->move(work_.trial_state, work_.step, 1.0, end_);
  ++result.evaluations;
  if (!potential.evaluate(end_, value)) return MinimiseEnd::no_descent;
  result.last.net_force_N = value.net_force_N;
  result.last.iterations = 1;
  return MinimiseEnd::converged;
}

/// Error and work; work_.current belongs to end_.
void TimeStepper::report(const Potential& potential, const Motion& motion, StepResult& result) {
  points_of(boundary_, end_, points_);
  double squared = 0.0, mass = 0.0;
  const auto count = [&](double m, Eigen::Index point) {
    squared +=
        m * (points_.segment<3>(3 * point) - start_.guess_m.segment<3>(3 * point)).squaredNorm();
    mass += m;
  };
  const Eigen::VectorXd& node_mass = potential.loads.node_mass_kg;
  for (const int node : unknowns_->free_nodes()) count(node_mass[node], node);
  for (std::size_t c = 0; c < boundary_.clips.size(); ++c) {
    const Clip& clip = boundary_.clips[c];
    if (clip.is_free) {
      for (const int node : clip.nodes) count(node_mass[node], node);
      count(clip.mass_kg, node_mass.size() + static_cast<Eigen::Index>(c));
      continue;
    }
    for (const int node : clip.nodes) {
      const auto first = 3 * static_cast<Eigen::Index>(node);
      result.work_J += work_.current.by_node.segment<3>(first).dot(end_.x.segment<3>(first) -
                                                                   motion.at.x.segment<3>(first));
    }
  }
  if (mass > 0.0) result.error_m = start_.error_share * std::sqrt(squared / mass);
}

}  // namespace tenter::mechanics
