// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/scene/simulation_document.h"

#include <nlohmann/json.hpp>

namespace tenter::jobs {
namespace {

using nlohmann::json;

json vector3(const std::vector<double>& list, std::size_t at) {
  return {list[3 * at], list[3 * at + 1], list[3 * at + 2]};
}

json row(const frames::FrameSet& f, std::size_t frame) {
  static constexpr const char* kStability[] = {"minimum", "neutral", "not_checked"};
  json energies = json::object();
  for (std::size_t t = 0; t < f.terms.size(); ++t)
    energies[f.terms[t]] = f.term_energy_J[frame * f.terms.size() + t];
  json reactions = json::object();
  for (std::size_t c = 0; c < f.clips.size(); ++c) {
    const std::size_t at = frame * f.clips.size() + c;
    reactions[f.clips[c]] = {{"position_m", vector3(f.clip_position_m, at)},
                             {"force_N", vector3(f.force_N, at)},
                             {"torque_N_m", vector3(f.torque_N_m, at)}};
  }
  const int phase = f.phase[frame];
  json result = {
      {"frame", frame},
      {"phase", phase < 0 ? json(nullptr) : json(f.phases[static_cast<std::size_t>(phase)])},
      {"phase_share", f.phase_share[frame]},
      {"steps", f.steps[frame]},
      {"iterations", f.iterations[frame]},
      {"stability", kStability[f.stability[frame]]},
      {"net_force_N", f.net_force_N[frame]},
      {"potential_J", f.potential_J[frame]},
      {"energies_J", energies},
      {"reactions", reactions}};
  if (!f.time_s.empty()) {
    result["time_s"] = f.time_s[frame];
    result["kinetic_J"] = f.kinetic_J[frame];
  }
  return result;
}

json parameters_json(const model::Model& model) {
  json list = json::array();
  for (const model::Term& term : model.terms)
    for (const model::Parameter& p : term.law.parameters)
      list.push_back({{"name", term.id + "." + p.name}, {"value", p.value}, {"unit", p.unit}});
  return list;
}

}  // namespace

json simulation_document(const scene::Scene& scene, const model::Model& model,
                         const frames::FrameSet& frames, const mechanics::SceneEnd& end) {
  json elements = json::object();
  for (const frames::Elements& e : frames.elements)
    if (e.count() > 0) elements[e.kind] = e.count();
  json rows = json::array();
  for (int frame = 0; frame < frames.frame_count(); ++frame)
    rows.push_back(row(frames, static_cast<std::size_t>(frame)));
  const bool completed = end.how == mechanics::SceneEnd::How::complete;
  return {{"schema", "tenter.simulation"},
          {"version", 1},
          {"kind", "simulate"},
          {"scene", scene.name},
          {"words", scene.description},
          {"model", model.name},
          {"parameters", parameters_json(model)},
          {"completed", completed},
          {"reason", completed ? json(nullptr) : json(end.reason)},
          {"frames_asked", scene.frame_count()},
          {"nodes", frames.nodes},
          {"elements", elements},
          {"clips", frames.clips},
          {"terms", frames.terms},
          {"frames", rows}};
}

}  // namespace tenter::jobs
