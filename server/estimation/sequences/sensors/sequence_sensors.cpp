// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/sensors/sequence_sensors.h"

#include "server/estimation/sequences/sensors/sensor_frame.h"

namespace tenter::estimation {

void SequenceSensors::show(const Sequence& sequence, std::size_t which, std::size_t frame,
                           const std::vector<Readings>& predicted,
                           const Eigen::VectorXd& parameters, bool sensitivities,
                           Readings& shown) const {
  const At at{sequence, which, frame, predicted, parameters, sensitivities};
  shown.value = predicted[frame].value;
  if (sensitivities) shown.by_p = predicted[frame].by_p;
  show_points(at, shown);
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    Shown& force = shown.scratch;
    show_force(at, k, force);
    shown.value[at.row(k)] = force.value;
    if (sensitivities) shown.by_p.row(at.row(k)) = force.by_p;
  }
}

Expected<void> without_corrections(const model::Model& model) {
  if (model.corrections.empty()) return {};
  return bad_input("the sensor correction \"" + model.corrections.front().id +
                   "\" has no place here: only single fits of sheets take them");
}

}  // namespace tenter::estimation
