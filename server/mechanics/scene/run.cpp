// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/scene/run.h"

#include <cmath>
#include <utility>

#include "common/model/catalogue.h"
#include "server/mechanics/dynamics/damping.h"

namespace tenter::mechanics {
namespace {

EquilibriumOptions options_of(const scene::Solver& solver) {
  EquilibriumOptions options;
  options.tolerance_N = solver.tolerance_N;
  options.max_iterations = solver.max_iterations;
  options.check_minimum = solver.check_minimum;
  options.contact_depth_m = solver.contact_depth_m;
  if (solver.minimiser == "additive_lm") options.minimiser = Minimiser::additive_lm;
  if (solver.minimiser == "relaxation") options.minimiser = Minimiser::relaxation;
  return options;
}

std::string place_words(const SceneFrame& frame, const scene::Scene& scene) {
  if (frame.phase < 0) return "frame 0, the start";
  return "frame " + std::to_string(frame.number) + ", " +
         std::to_string(std::lround(100.0 * frame.share)) + " % into phase '" +
         scene.protocol[static_cast<std::size_t>(frame.phase)].name + "'";
}

/// A mesh that nothing holds runs away under any load.
bool is_worth_steps(MinimiseEnd end) {
  return end != MinimiseEnd::runs_away && end != MinimiseEnd::start_not_finite &&
         end != MinimiseEnd::out_of_memory;
}

}  // namespace

Expected<SceneRun> SceneRun::make(const scene::Scene& scene, const model::Model& model) {
  SceneRun run;
  run.scene_ = scene;
  auto body = make_body(scene);
  if (!body) return tl::unexpected(body.error());
  run.body_ = std::move(*body);
  run.description_ = model;
  if (scene.dynamics) {
    auto damped = with_damping(model, scene.dynamics->damping_s);
    if (!damped) return fail(damped.error().kind, "dynamics.damping_s: " + damped.error().message);
    if (scene.dynamics->damping_s > 0.0) run.description_ = std::move(*damped);
  }
  auto bound = bind(run.description_, run.body_);
  if (!bound) return fail(bound.error().kind, "model: " + bound.error().message);
  run.model_ = std::make_unique<const MeshModel>(std::move(*bound));
  auto set_up = make_set_up(scene, run.body_);
  if (!set_up) return tl::unexpected(set_up.error());
  run.set_up_ = std::move(*set_up);
  auto solver = EquilibriumSolver::make(*run.model_, run.set_up_.boundary, run.set_up_.obstacles);
  if (!solver) return tl::unexpected(solver.error());
  run.solver_ = std::make_unique<EquilibriumSolver>(std::move(*solver));
  run.parameters_ = term_parameters(run.description_);
  for (std::size_t t = 0; t < run.description_.terms.size(); ++t)
    if (model::find_law(run.description_.terms[t].law.name)->path_dependent)
      run.remembering_.push_back(static_cast<int>(t));
  run.options_ = options_of(scene.solver);
  return run;
}

Expected<bool> SceneRun::solve(const Levels& levels, bool is_near, State& state,
                               SceneFrame& frame) {
  State there = state;
  for (std::size_t c = 0; c < levels.clips.size(); ++c)
    if (!set_up_.boundary.clips[c].is_free) there.clips[c] = levels.clips[c];
  EquilibriumOptions options = options_;
  options.start_is_near = is_near;
  auto result =
      solver_->solve(parameters_, loads_at(set_up_, body_, levels), there, options, &history_);
  if (!result) return tl::unexpected(result.error());
  frame.iterations += result->iterations;
  frame.factorisations += result->factorisations;
  last_ = std::move(*result);
  if (!last_.is_good(options) || !there.x.allFinite()) {
    failure_ = describe(last_, options);
    return false;
  }
  if (!remember(state, there)) {
    failure_ = "what the material remembers of its path are no numbers";
    return false;
  }
  state = std::move(there);
  return true;
}

bool SceneRun::begin_history(const State& start) {
  history_ = model_->never_strained();
  work_J_.setZero(model_->term_count());
  is_new_ = !scene_.start.is_remembered;
  if (is_new_ || remembering_.empty()) return true;
  if (model_->end_of_step(start.x, parameters_, history_, history_.state) == AssemblyStatus::ok)
    return true;
  failure_ = "the material cannot be brought to where it starts";
  return false;
}

bool SceneRun::remember(const State& from, const State& to) {
  if (remembering_.empty()) return true;
  Eigen::VectorXd before = Eigen::VectorXd::Zero(work_J_.size()), after;
  if (!is_new_ &&
      model_->term_energies(from.x, parameters_, before, &history_) != AssemblyStatus::ok)
    return false;
  if (model_->term_energies(to.x, parameters_, after, &history_) != AssemblyStatus::ok ||
      model_->end_of_step(to.x, parameters_, history_, history_.state) != AssemblyStatus::ok)
    return false;
  work_J_ += after - before;
  is_new_ = false;
  return true;
}

Expected<bool> SceneRun::begin(const Levels& levels, const SceneHooks& hooks, State& state,
                               SceneFrame& frame) {
  const auto go_on = [&] {
    was_stopped_ = hooks.go_on && !hooks.go_on(0, frame.iterations);
    return !was_stopped_;
  };
  if (!go_on()) return false;
  auto found = solve(levels, false, state, frame);
  if (!found || *found || scene_.solver.most_halvings == 0) return found;
  if (!is_worth_steps(last_.last.end) || !go_on()) return found;
  const std::string at_once = failure_;
  const auto part = [&levels](double share) { return loaded_in_part(levels, share); };
  found = solve(part(0.0), false, state, frame);
  if (found && *found) found = advance(part, 0.0, 1.0, hooks, state, frame);
  if (found && !*found) failure_ = at_once;
  return found;
}

Expected<bool> SceneRun::advance(const std::function<Levels(double)>& levels_at, double from,
                                 double to, const SceneHooks& hooks, State& state,
                                 SceneFrame& frame) {
  const double smallest = std::ldexp(to - from, -scene_.solver.most_halvings);
  double step = to - from;
  double reached = from;
  while (reached < to) {
    // what is left is a multiple of the step, but for rounding
    const double target = 1.5 * step > to - reached ? to : reached + step;
    const Levels levels = levels_at(target);
    bool is_there = false;
    for (const bool is_near : {true, false}) {
      if (hooks.go_on && !hooks.go_on(frame.number, frame.iterations)) {
        was_stopped_ = true;
        return false;
      }
      auto solved = solve(levels, is_near, state, frame);
      if (!solved) return solved;
      is_there = *solved;
      if (is_there) break;
    }
    if (is_there) {
      reached = target;
      ++frame.steps;
    } else if (step > smallest) {
      step *= 0.5;
    } else {
      return false;
    }
  }
  return true;
}

bool SceneRun::tell(const Levels& levels, const State& state, Eigen::VectorXd by_node,
                    SceneFrame& frame) {
  frame.state = state;
  frame.levels = levels;
  if (!set_up_.boundary.pressed.empty())
    by_node -= rim_force_N(set_up_.boundary, levels.pressure_Pa, state.x);
  frame.reactions.clear();
  for (std::size_t c = 0; c < set_up_.boundary.clips.size(); ++c)
    frame.reactions.push_back(
        reaction(set_up_.boundary.clips[c], state.x, by_node, state.clips[c].position_m));
  if (model_->term_energies(state.x, parameters_, frame.term_energies_J) != AssemblyStatus::ok ||
      model_->term_strains(state.x, frame.strains) != AssemblyStatus::ok) {
    failure_ = "energies or strains of the state are no numbers";
    return false;
  }
  for (const int term : remembering_) frame.term_energies_J[term] = work_J_[term];
  return true;
}

Expected<bool> SceneRun::finish(const Levels& levels, const State& state, SceneFrame& frame) {
  tell_rest(frame);
  frame.energy_J = last_.energy_J;
  return tell(levels, state, last_.by_node, frame);
}

void SceneRun::tell_rest(SceneFrame& frame) const {
  frame.stability = last_.stability;
  frame.net_force_N = last_.last.net_force_N;
  frame.contact_violation_m = last_.contact_violation_m;
  frame.limit_violation = last_.limit_violation;
}

Expected<SceneEnd> SceneRun::walk(const SceneHooks& hooks) {
  if (scene_.dynamics) return walk_in_time(hooks);
  SceneEnd end;
  State state = set_up_.start;
  Levels levels = first_levels(scene_, state.clips);
  was_stopped_ = false;
  if (!begin_history(state)) {
    end.how = SceneEnd::How::failed;
    end.reason = failure_;
    return end;
  }
  const auto hand_out = [&](SceneFrame& frame, const Levels& now,
                            Expected<bool> found) -> Expected<bool> {
    if (found && *found) found = finish(now, state, frame);
    if (!found) return found;
    if (*found) {
      if (hooks.on_frame) hooks.on_frame(frame);
      ++end.frames;
      return true;
    }
    end.how = was_stopped_ ? SceneEnd::How::stopped : SceneEnd::How::failed;
    if (!was_stopped_)
      end.reason = "no equilibrium was found for " + place_words(frame, scene_) + ": " + failure_;
    return false;
  };

  SceneFrame frame;
  auto good = hand_out(frame, levels, begin(levels, hooks, state, frame));
  for (std::size_t p = 0; good && *good && p < scene_.protocol.size(); ++p) {
    const scene::Phase& phase = scene_.protocol[p];
    for (int f = 1; good && *good && f <= phase.frames; ++f) {
      const int number = frame.number + 1;
      frame = SceneFrame();
      frame.number = number;
      frame.steps = 0;
      frame.phase = static_cast<int>(p);
      frame.share = static_cast<double>(f) / phase.frames;
      const double from = static_cast<double>(f - 1) / phase.frames;
      const auto levels_at = [&](double share) { return levels_in(scene_, phase, levels, share); };
      auto found = advance(levels_at, from, frame.share, hooks, state, frame);
      good = hand_out(frame, levels_at(frame.share), std::move(found));
    }
    levels = levels_in(scene_, phase, levels, 1.0);
  }
  if (!good) return tl::unexpected(good.error());
  return end;
}

}  // namespace tenter::mechanics
