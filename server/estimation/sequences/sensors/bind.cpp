// SPDX-License-Identifier: GPL-3.0-or-later
// Which sequences and channels a model's corrections are of, and what of a sequence they need.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/model/catalogue.h"
#include "server/estimation/instrument/last_motion.h"
#include "server/estimation/sequences/material/material_locator.h"
#include "server/estimation/sequences/sensors/hidden_points.h"
#include "server/estimation/sequences/sensors/sensor_frame.h"

namespace tenter::estimation {

namespace {

/// In the order of SequenceSensors::Type; those from camera_scale to occlusion_bias, and the mass,
/// are of whole sequences.
constexpr const char* kTypes[] = {"offset",         "gain",       "drift",        "delay",
                                  "cord_friction",  "saturation", "camera_scale", "camera_pose",
                                  "occlusion_bias", "clip_slip",  "mass_scale"};

/// Of what the first frame saw; a coordinate that it did not is that of its start.
Eigen::Vector3d middle_of(const Sequence& sequence) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  if (sequence.points.empty()) return middle;
  const SequenceFrame& first = sequence.frames.front();
  const mechanics::State& start = first.start ? *first.start : sequence.start;
  const MaterialLocator locator(sequence.cloth.mesh);
  for (int c = 0; c < 3; ++c) {
    double seen = 0.0, at_start = 0.0;
    int count = 0;
    for (std::size_t k = 0; k < sequence.points.size(); ++k) {
      const double value = first.points_m(c, static_cast<Eigen::Index>(k));
      const auto place = locator.locate(sequence.points[k].material_m);
      if (place) at_start += place->position(start.x)[c];
      if (std::isnan(value)) continue;
      seen += value;
      ++count;
    }
    middle[c] = count > 0 ? seen / count : at_start / static_cast<double>(sequence.points.size());
  }
  return middle;
}

/// How far a channel's clip has gone along it, frame by frame.
std::vector<double> travel_m(const Sequence& sequence, std::size_t force) {
  const auto clip = static_cast<std::size_t>(sequence.forces[force].clip);
  const mechanics::Clip& body = sequence.boundaries.front().clips[clip];
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& node : body.place_m) place += node;
  if (!body.place_m.empty()) place /= static_cast<double>(body.place_m.size());
  std::vector<double> travel;
  Eigen::Vector3d before = sequence.frames.front().clips[clip].to_space(place);
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const Eigen::Vector3d now = sequence.frames[f].clips[clip].to_space(place);
    const double moved = direction_of(sequence, force, f).dot(now - before);
    travel.push_back((travel.empty() ? 0.0 : travel.back()) + moved);
    before = now;
  }
  return travel;
}

}  // namespace

Expected<SequenceSensors> SequenceSensors::make(const model::Model& model,
                                                const std::vector<Sequence>& sequences) {
  SequenceSensors sensors;
  for (const model::Term& term : model.terms)
    sensors.parameter_count_ += static_cast<int>(term.law.parameters.size());
  for (const model::SensorCorrection& description : model.corrections) {
    auto bound = bind(description, sequences);
    if (!bound)
      return bad_input("the sensor correction \"" + description.id + "\" " + bound.error().message);
    bound->first_parameter = sensors.parameter_count_;
    sensors.parameter_count_ += static_cast<int>(description.parameters.size());
    sensors.corrections_.push_back(std::move(*bound));
  }
  if (sensors.is_empty()) return sensors;
  for (const Sequence& sequence : sequences) sensors.known_.push_back(sensors.know(sequence));
  return sensors;
}

Expected<SequenceSensors::Correction> SequenceSensors::bind(
    const model::SensorCorrection& description, const std::vector<Sequence>& sequences) {
  const model::CorrectionRow* row = model::find_correction(description.type, model::Seen::sheets);
  const auto* type = std::find(std::begin(kTypes), std::end(kTypes), description.type);
  if (row == nullptr || type == std::end(kTypes))
    return bad_input("is of type " + description.type + ", which sheets do not have");
  if (!fits(description, *row)) {
    std::string wanted;
    for (const model::ParameterRow& p : row->parameters)
      wanted +=
          (wanted.empty() ? "" : ", ") + std::string(p.name) + " (" + std::string(p.unit) + ")";
    return bad_input("does not have the parameters of a sheet's " + description.type + ": " +
                     wanted);
  }
  Correction bound;
  bound.type = static_cast<Type>(type - std::begin(kTypes));
  const bool is_of_forces = bound.type <= Type::saturation || bound.type == Type::clip_slip;
  if (!is_of_forces && !description.component.empty())
    return bad_input("is of whole sequences, not of the channel \"" + description.component + "\"");
  if (bound.type == Type::clip_slip && description.component.empty())
    return bad_input("does not say by a channel which clip slipped");
  bool has_sequence = false, has_channel = false;
  for (const Sequence& sequence : sequences) {
    const bool is_of_it = description.capture.empty() || description.capture == sequence.name;
    has_sequence = has_sequence || is_of_it;
    auto& forces = bound.forces.emplace_back(sequence.forces.size(), false);
    bool is_on = is_of_it && !is_of_forces;
    for (std::size_t k = 0; k < sequence.forces.size() && is_of_it && is_of_forces; ++k) {
      const ForceChannel& force = sequence.forces[k];
      forces[k] = description.component.empty() || description.component == force.name;
      is_on = is_on || forces[k];
      if (!forces[k] || bound.type != Type::clip_slip) continue;
      for (const mechanics::Boundary& boundary : sequence.boundaries)
        if (boundary.clips[static_cast<std::size_t>(force.clip)].is_free)
          return bad_input("is of a free clip, which goes where the cloth does");
    }
    has_channel = has_channel || is_on;
    bound.on.push_back(is_on);
  }
  if (!has_sequence)
    return bad_input("is of a sequence \"" + description.capture + "\", which there is not");
  if (!has_channel && description.component.empty())
    return bad_input("is of forces, but none is measured");
  if (!has_channel)
    return bad_input("is of a force \"" + description.component + "\", which there is not");
  return bound;
}

SequenceSensors::Known SequenceSensors::know(const Sequence& sequence) const {
  Known known;
  double clock_s = 0.0;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    if (f > 0) clock_s += sequence.frames[f].duration_s;
    known.clock_s.push_back(clock_s);
  }
  constexpr double kLeastTravel_m = 1e-6;
  for (std::size_t k = 0; k < sequence.forces.size(); ++k)
    known.motion.push_back(last_motions(travel_m(sequence, k), {}, kLeastTravel_m));
  known.middle_m = middle_of(sequence);
  const bool has_occlusion =
      std::any_of(corrections_.begin(), corrections_.end(),
                  [](const Correction& c) { return c.type == Type::occlusion_bias; });
  if (has_occlusion) known.from_hidden = hidden_distances(sequence);
  return known;
}

}  // namespace tenter::estimation
