// SPDX-License-Identifier: GPL-3.0-or-later
// Cords, clocks and load cells, in the order in which a force passes them.
#include "server/estimation/instrument/moment.h"
#include "server/estimation/sequences/sensors/sensor_frame.h"

namespace tenter::estimation {

/// Adds weight times the tension of a frame: the force with the friction of its cord.
void SequenceSensors::hang(const At& at, std::size_t force, int frame, double weight,
                           Shown& shown) const {
  const auto f = static_cast<std::size_t>(frame);
  const Readings& predicted = at.predicted[f];
  const double value = predicted.value[at.row(force)];
  double factor = 1.0;
  for (const Correction& c : corrections_) {
    if (c.type != Type::cord_friction || !c.forces[at.which][force]) continue;
    const double s = known_[at.which].motion[force][f];
    factor += at.parameters[c.first_parameter] * s;
    if (at.sensitivities) shown.by_p[c.first_parameter] += weight * s * value;
  }
  shown.value += weight * factor * value;
  if (at.sensitivities) shown.by_p += (weight * factor) * predicted.by_p.row(at.row(force));
}

/// The tension of now, or of a delay ago; delays add up. With r0 and r1 the tensions before and
/// after the moment that is shown,
///
///   T = (1 - w) r0 + w r1      dT/ddelay = (r0 - r1) / span
void SequenceSensors::hang_late(const At& at, std::size_t force, Shown& shown) const {
  const auto start_over = [&] {
    shown.value = 0.0;
    if (at.sensitivities) shown.by_p.setZero(parameter_count_);
  };
  const auto is_own = [&](const Correction& c) {
    return c.type == Type::delay && c.forces[at.which][force];
  };
  const std::vector<double>& clock_s = known_[at.which].clock_s;
  const auto frame = static_cast<int>(at.frame);
  double when_s = clock_s[at.frame];
  bool is_late = false;
  for (const Correction& c : corrections_) {
    if (!is_own(c)) continue;
    when_s -= at.parameters[c.first_parameter];
    is_late = true;
  }
  start_over();
  if (!is_late) return hang(at, force, frame, 1.0, shown);
  const auto moment = moment_at(clock_s, 0, static_cast<int>(clock_s.size()), frame, when_s);
  if (!moment) return hang(at, force, frame, 1.0, shown);
  At values = at;
  values.sensitivities = false;
  hang(values, force, moment->later - 1, 1.0, shown);
  hang(values, force, moment->later, -1.0, shown);
  const double by_delay = moment->span_s > 0.0 ? shown.value / moment->span_s : 0.0;
  start_over();
  hang(at, force, moment->later - 1, 1.0 - moment->weight, shown);
  hang(at, force, moment->later, moment->weight, shown);
  if (!at.sensitivities) return;
  for (const Correction& c : corrections_)
    if (is_own(c)) shown.by_p[c.first_parameter] = by_delay;
}

void SequenceSensors::show_force(const At& at, std::size_t force, Shown& shown) const {
  const auto each = [&](Type type, const auto& work) {
    for (const Correction& c : corrections_)
      if (c.type == type && c.forces[at.which][force]) work(c.first_parameter);
  };
  const Eigen::VectorXd& p = at.parameters;
  const double clock_s = known_[at.which].clock_s[at.frame];
  hang_late(at, force, shown);
  each(Type::gain, [&](int own) { amplify(p[own], own, at.sensitivities, shown); });
  each(Type::offset, [&](int own) { add(p[own], 1.0, own, at.sensitivities, shown); });
  each(Type::drift, [&](int own) { add(p[own], clock_s, own, at.sensitivities, shown); });
  each(Type::saturation,
       [&](int own) { cut_off(p[own], p[own + 1], own, at.sensitivities, shown); });
}

}  // namespace tenter::estimation
