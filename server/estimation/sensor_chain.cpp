// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sensor_chain.h"

#include <algorithm>
#include <iterator>

#include "common/model/catalogue.h"
#include "server/estimation/instrument/moment.h"

namespace tenter::estimation {

/// Const references that live for one call.
struct SensorChain::Frame {
  const Curves& curves;
  const mechanics::PathResponse& response;
  const Eigen::VectorXd& parameters;
  int which;
  int component;
  int frame;
  bool sensitivities;

  const CurveRun& run() const {
    const int block = curves.block_of[static_cast<std::size_t>(frame)];
    const int run = curves.blocks[static_cast<std::size_t>(block)].run;
    return curves.runs[static_cast<std::size_t>(run)];
  }
  double clock(int f) const { return curves.clock_s[static_cast<std::size_t>(f)]; }
};

Expected<SensorChain> SensorChain::make(const model::Model& model,
                                        const std::vector<Curves>& curves, int term_parameters) {
  static constexpr const char* kTypes[] = {"offset",     "gain",         "drift",
                                           "delay",      "clip_slip",    "cord_friction",
                                           "saturation", "camera_scale", "camera_length"};
  SensorChain chain;
  chain.term_parameters_ = chain.parameter_count_ = term_parameters;
  bool has_cord = false;
  for (const model::SensorCorrection& description : model.corrections) {
    Correction correction;
    const auto* type = std::find(std::begin(kTypes), std::end(kTypes), description.type);
    if (type == std::end(kTypes))
      return bad_input("no sensor correction is called \"" + description.type + "\"");
    if (const auto* row = model::find_correction(description.type);
        !row || !fits(description, *row))
      return bad_input("the correction \"" + description.id + "\" is not one of curves");
    correction.type = static_cast<Type>(type - std::begin(kTypes));
    correction.capture = description.capture;
    for (int i = 0; i < 3; ++i)
      if (description.component == component_name(i)) correction.component = i;
    correction.first_parameter = chain.parameter_count_;
    chain.parameter_count_ += static_cast<int>(description.parameters.size());
    has_cord = has_cord || correction.type == Type::cord_friction;
    chain.corrections_.push_back(correction);
  }
  if (!has_cord) return chain;
  for (const Curves& c : curves)
    chain.direction_.push_back(
        {last_motions_of(c, 0), last_motions_of(c, 1), last_motions_of(c, 2)});
  return chain;
}

/// Adds weight times the tension at a frame: the stress with the friction of its cords.
void SensorChain::hang(const Frame& at, int frame, double weight, Shown& shown) const {
  const double stress = at.response.stress[static_cast<std::size_t>(frame)][at.component];
  double factor = 1.0;
  for (const Correction& c : corrections_) {
    if (c.type != Type::cord_friction || !c.applies(at.curves, at.component)) continue;
    const double s =
        direction_[static_cast<std::size_t>(at.which)][static_cast<std::size_t>(at.component)]
                  [static_cast<std::size_t>(frame)];
    factor += at.parameters[c.first_parameter] * s;
    if (at.sensitivities) shown.by_p[c.first_parameter] += weight * s * stress;
  }
  shown.value += weight * factor * stress;
  if (at.sensitivities)
    shown.by_p.head(term_parameters_) +=
        weight * factor * at.response.stress_by_p.row(3 * frame + at.component);
}

/// The tension of now, or of a delay ago: linear between frames; before its first and after its
/// last frame a run shows these.
void SensorChain::shift(const Frame& at, Shown& shown) const {
  const auto start_over = [&] {
    shown.value = 0.0;
    if (at.sensitivities) shown.by_p.setZero(parameter_count_);
  };
  start_over();
  hang(at, at.frame, 1.0, shown);
  for (const Correction& c : corrections_) {
    if (c.type != Type::delay || !c.applies(at.curves, at.component)) continue;
    const CurveRun& run = at.run();
    const auto moment = moment_at(at.curves.clock_s, run.first, run.last, at.frame,
                                  at.clock(at.frame) - at.parameters[c.first_parameter]);
    if (!moment) continue;
    start_over();
    hang(at, moment->later - 1, 1.0 - moment->weight, shown);
    hang(at, moment->later, moment->weight, shown);
    if (!at.sensitivities || moment->span_s == 0.0) continue;
    // T0 and T1 themselves: their weights may be zero
    Shown ends;
    Frame values = at;
    values.sensitivities = false;
    hang(values, moment->later - 1, -1.0, ends);
    hang(values, moment->later, 1.0, ends);
    shown.by_p[c.first_parameter] = -ends.value / moment->span_s;
  }
}

/// What one unit of an additive correction adds.
double SensorChain::added(const Correction& c, const Frame& at,
                          const Eigen::VectorXd& parameters) const {
  if (c.type == Type::offset) return 1.0;
  if (c.type == Type::drift) return at.clock(at.frame) - at.curves.clock_s.front();
  // the step belongs to the run that holds its frame; at_frame counts the capture's frames, thinned
  // or not
  const int step = static_cast<int>(parameters[c.first_parameter + 1]);
  const CurveRun& own = at.run();
  const auto origin = [&](int f) { return at.curves.origin[static_cast<std::size_t>(f)]; };
  const bool is_last = own.last == static_cast<int>(at.curves.frame_count());
  const bool in_run = step >= origin(own.first) && (is_last || step < origin(own.last));
  return in_run && origin(at.frame) >= step ? 1.0 : 0.0;
}

void SensorChain::show_stress(const Curves& curves, int which,
                              const mechanics::PathResponse& response, int component, int frame,
                              const Eigen::VectorXd& parameters, bool sensitivities,
                              Shown& shown) const {
  const Frame at{curves, response, parameters, which, component, frame, sensitivities};
  shift(at, shown);
  for (const Correction& c : corrections_) {
    if (c.type != Type::gain || !c.applies(curves, component)) continue;
    amplify(parameters[c.first_parameter], c.first_parameter, sensitivities, shown);
  }
  for (const Correction& c : corrections_) {
    const bool adds = c.type == Type::offset || c.type == Type::drift || c.type == Type::clip_slip;
    if (!adds || !c.applies(curves, component)) continue;
    add(parameters[c.first_parameter], added(c, at, parameters), c.first_parameter, sensitivities,
        shown);
  }
  for (const Correction& c : corrections_) {
    if (c.type != Type::saturation || !c.applies(curves, component)) continue;
    cut_off(parameters[c.first_parameter], parameters[c.first_parameter + 1], c.first_parameter,
            sensitivities, shown);
  }
}

void SensorChain::show_stretch(const Curves& curves, const mechanics::PathResponse& response,
                               int component, int frame, const Eigen::VectorXd& parameters,
                               bool sensitivities, Shown& shown) const {
  shown.value = response.q[static_cast<std::size_t>(frame)][component];
  if (sensitivities) {
    shown.by_p.setZero(parameter_count_);
    shown.by_p.head(term_parameters_) = response.q_by_p.row(3 * frame + component);
  }
  if (component == 2) return;  // a ratio of lengths: every scale drops out of shear
  for (const Correction& c : corrections_) {
    const bool scales = c.type == Type::camera_scale || c.type == Type::camera_length;
    if (!scales || !c.applies(curves, component)) continue;
    const double scale = parameters[c.first_parameter];
    const double rest = c.type == Type::camera_scale ? 1.0 : 0.0;
    const double moved = shown.value - rest;
    shown.value = rest + scale * moved;
    if (!sensitivities) continue;
    shown.by_p *= scale;
    shown.by_p[c.first_parameter] = moved;
  }
}

}  // namespace tenter::estimation
