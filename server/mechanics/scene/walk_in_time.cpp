// SPDX-License-Identifier: GPL-3.0-or-later
// A scene in motion: steps to the instant of every frame, boundary and loads along the protocol.
#include <cmath>
#include <utility>

#include "server/mechanics/contact/crossings.h"
#include "server/mechanics/dynamics/motion_energy.h"
#include "server/mechanics/scene/run.h"

namespace tenter::mechanics {
namespace {

StepOptions options_of(const scene::Scene& scene) {
  StepOptions options;
  options.scheme = scene.dynamics->scheme == "bdf2" ? TimeScheme::bdf2 : TimeScheme::implicit_euler;
  options.tolerance_N = scene.solver.tolerance_N;
  options.max_iterations = scene.solver.max_iterations;
  options.contact_depth_m = scene.solver.contact_depth_m;
  options.is_linearised = scene.dynamics->is_linearised;
  return options;
}

StepLength length_of(const scene::Scene& scene) {
  StepLength length;
  length.largest_s = scene.dynamics->step_s;
  length.error_m = scene.dynamics->error_m;
  // a step that follows its error becomes much shorter than one that fails
  const int halvings = scene.solver.most_halvings + (length.error_m > 0.0 ? 10 : 0);
  length.smallest_s = std::ldexp(length.largest_s, -halvings);
  return length;
}

int crossings_at(const SceneBody& body, const State& start) {
  const auto* cloth = std::get_if<Cloth>(&body.mesh);
  return cloth ? crossings(cloth->mesh, start.x) : 0;
}

/// So stiff that a vertex pressed to half of the thickness bears ten of its weights.
Expected<SelfContact> self_contact_of(const SceneBody& body, double thickness_m) {
  const auto* cloth = std::get_if<Cloth>(&body.mesh);
  if (!cloth) return bad_input("is for sheets");
  constexpr double kWeights = 10.0, kGravity_m_s2 = 9.81, kAtHalf = 1.2;  // self_contact.h
  const double weight_N = kGravity_m_s2 * body.node_mass_kg.mean();
  return SelfContact::make(cloth->mesh, thickness_m, kWeights * weight_N / (kAtHalf * thickness_m));
}

}  // namespace

StepInput SceneRun::input_at(const Levels& levels) const {
  return {0.0, loads_at(set_up_, body_, levels), levels.clips, obstacles_at(set_up_, levels)};
}

bool SceneRun::count_work(const Motion& motion) {
  if (remembering_.empty()) return true;
  history_.state = motion.last_history;
  history_.duration_s = motion.last_step_s;
  Eigen::VectorXd before, after;
  if (model_->term_energies(motion.last_points_m.head(motion.at.x.size()), parameters_, before,
                            &history_) != AssemblyStatus::ok ||
      model_->term_energies(motion.at.x, parameters_, after, &history_) != AssemblyStatus::ok)
    return false;
  after -= before;
  // a dashpot's incremental potential is half of what it takes
  for (const int term : remembering_)
    if (description_.terms[static_cast<std::size_t>(term)].law.name == "kelvin_voigt")
      after[term] *= 2.0;
  work_J_ += after;
  return true;
}

bool SceneRun::finish_instant(const Levels& levels, const Motion& motion,
                              const Eigen::VectorXd& by_node, SceneFrame& frame) {
  const State& state = motion.at;
  if (!tell(levels, state, by_node, frame)) return false;
  Eigen::VectorXd stored_J = frame.term_energies_J;
  for (const int term : remembering_) stored_J[term] = 0.0;
  const Loads loads = loads_at(set_up_, body_, levels);
  frame.energy_J = stored_J.sum();
  add_loads(loads, set_up_.boundary, state.x, {&frame.energy_J});
  for (std::size_t c = 0; c < set_up_.boundary.clips.size(); ++c)
    if (set_up_.boundary.clips[c].is_free)
      frame.energy_J +=
          clip_potential_J(loads, set_up_.boundary, static_cast<int>(c), state.clips[c]);
  SceneInstant& instant = frame.instant.emplace();
  instant.time_s = motion.time_s;
  instant.kinetic_J = momenta(set_up_.boundary, loads.node_mass_kg, motion).kinetic_J;
  instant.velocity_m_s = motion.velocity_m_s.head(state.x.size());
  return true;
}

Expected<SceneEnd> SceneRun::walk_in_time(const SceneHooks& hooks) {
  SceneEnd end;
  Levels levels = first_levels(scene_, set_up_.start.clips);
  was_stopped_ = false;
  auto stepper = TimeStepper::make(*model_, set_up_.boundary, set_up_.obstacles);
  if (!stepper) return tl::unexpected(stepper.error());
  if (const double thickness_m = scene_.dynamics->self_contact_m; thickness_m > 0.0) {
    auto contact = self_contact_of(body_, thickness_m);
    if (!contact)
      return fail(contact.error().kind, "dynamics.self_contact_m: " + contact.error().message);
    stepper->keep_apart(std::move(*contact));
  }
  const auto stop = [&](const std::string& reason) {
    end.how = was_stopped_ ? SceneEnd::How::stopped : SceneEnd::How::failed;
    if (!was_stopped_) end.reason = reason;
    return end;
  };

  SceneFrame frame;
  State start = set_up_.start;
  place_clips(set_up_.boundary, start);
  if (!begin_history(start)) return stop(failure_);
  if (scene_.dynamics->from_rest) {
    const auto found = begin(levels, hooks, start, frame);
    if (!found) return tl::unexpected(found.error());
    if (!*found) return stop("no equilibrium was found for frame 0, the start: " + failure_);
    tell_rest(frame);
  } else if (hooks.go_on && !hooks.go_on(0, 0)) {
    was_stopped_ = true;
    return stop("");
  }
  if (const int places = scene_.dynamics->self_contact_m > 0.0 ? crossings_at(body_, start) : 0)
    return stop("the sheet goes through itself at its start, at " + std::to_string(places) +
                " places: it cannot be kept from it any more (dynamics.self_contact_m)");
  Motion motion = at_rest(set_up_.boundary, start);
  if (scene_.dynamics->from_rest || scene_.start.is_remembered)
    motion.history = motion.last_history = history_.state;

  // what holders feel at the start is what they would at rest
  Eigen::VectorXd by_node;
  ModelOutput wanted;
  wanted.gradient = &by_node;
  if (model_->evaluate(start.x, parameters_, wanted) != AssemblyStatus::ok)
    return stop("frame 0, the start: the material has no forces there");
  add_loads(loads_at(set_up_, body_, levels), set_up_.boundary, start.x, {nullptr, by_node.data()});
  if (!finish_instant(levels, motion, by_node, frame)) return stop(failure_);
  if (hooks.on_frame) hooks.on_frame(frame);
  ++end.frames;

  const StepOptions options = options_of(scene_);
  StepLength length = length_of(scene_);
  double phase_start_s = 0.0;
  for (std::size_t p = 0; p < scene_.protocol.size(); ++p) {
    const scene::Phase& phase = scene_.protocol[p];
    const double duration_s = *phase.duration_s;
    const Script script = [&](double time_s) {
      return input_at(levels_in(scene_, phase, levels, (time_s - phase_start_s) / duration_s));
    };
    for (int f = 1; f <= phase.frames; ++f) {
      const int number = frame.number + 1;
      frame = SceneFrame();
      frame.number = number;
      frame.phase = static_cast<int>(p);
      frame.share = static_cast<double>(f) / phase.frames;
      WalkHooks on_the_way;
      on_the_way.go_on = [&] {
        was_stopped_ = hooks.go_on && !hooks.go_on(frame.number, frame.iterations);
        return !was_stopped_;
      };
      on_the_way.on_step = [&](const Motion& now) { return count_work(now); };
      const auto walked =
          walk_until(*stepper, parameters_, script, phase_start_s + frame.share * duration_s,
                     options, length, motion, on_the_way);
      if (!walked) return tl::unexpected(walked.error());
      if (walked->how != WalkEnd::How::complete)
        return stop(walked->reason.empty() ? "the work of the material is no number"
                                           : walked->reason);
      frame.steps = walked->steps;
      frame.iterations = walked->iterations;
      frame.factorisations = walked->factorisations;
      frame.net_force_N = walked->last.last.net_force_N;
      frame.contact_violation_m = walked->last.violation.contact_m;
      frame.limit_violation = walked->last.violation.limit;
      if (!finish_instant(levels_in(scene_, phase, levels, frame.share), motion, stepper->by_node(),
                          frame))
        return stop(failure_);
      frame.instant->error_m = walked->error_m;
      if (hooks.on_frame) hooks.on_frame(frame);
      ++end.frames;
    }
    levels = levels_in(scene_, phase, levels, 1.0);
    phase_start_s += duration_s;
  }
  return end;
}

}  // namespace tenter::mechanics
