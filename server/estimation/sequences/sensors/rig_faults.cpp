// SPDX-License-Identifier: GPL-3.0-or-later
// What the rig did to the sheet: it changes the equilibrium, not only what is shown of it.
//
//   G = dPi/dx = ... - scale m_i g     dG/dscale = -m_i g
//   x_i = pose place_i - length d      dx_i/dlength = -d      of the nodes of a clip that slipped
#include <algorithm>

#include "server/estimation/sequences/sensors/sensor_frame.h"

namespace tenter::estimation {

std::vector<Eigen::Index> SequenceSensors::felt(std::size_t which) const {
  std::vector<Eigen::Index> parameters;
  for (const Correction& c : corrections_)
    if ((c.type == Type::mass_scale || c.type == Type::clip_slip) && c.on[which])
      parameters.push_back(c.first_parameter);
  return parameters;
}

bool SequenceSensors::is_slipped(const Correction& c, std::size_t which, std::size_t force,
                                 std::size_t frame, const Eigen::VectorXd& parameters) const {
  return c.type == Type::clip_slip && c.forces[which][force] &&
         static_cast<double>(frame) >= parameters[c.first_parameter + 1];
}

void SequenceSensors::act(const Sequence& sequence, std::size_t which, std::size_t frame,
                          const Eigen::VectorXd& parameters, mechanics::Loads& loads,
                          std::vector<mechanics::Pose>& clips) const {
  double mass_scale = 1.0;
  for (const Correction& c : corrections_) {
    if (!c.on[which]) continue;
    const double value = parameters[c.first_parameter];
    if (c.type == Type::mass_scale) mass_scale += value - 1.0;
    for (std::size_t k = 0; k < sequence.forces.size(); ++k)
      if (is_slipped(c, which, k, frame, parameters))
        clips[static_cast<std::size_t>(sequence.forces[k].clip)].position_m -=
            value * direction_of(sequence, k, frame);
  }
  if (mass_scale != 1.0) loads.node_mass_kg *= mass_scale;
}

mechanics::OuterChange SequenceSensors::outer_change(
    const Sequence& sequence, std::size_t which, std::size_t frame,
    const Eigen::VectorXd& parameters, const std::vector<Eigen::Index>& columns) const {
  const auto nodes = static_cast<Eigen::Index>(sequence.cloth.mesh.node_count());
  mechanics::OuterChange change;
  change.load_N.setZero(3 * nodes, static_cast<Eigen::Index>(columns.size()));
  change.held_m = change.load_N;
  for (const Correction& c : corrections_) {
    const auto at = std::find(columns.begin(), columns.end(), c.first_parameter);
    if (!c.on[which] || at == columns.end()) continue;
    const auto column = static_cast<Eigen::Index>(at - columns.begin());
    if (c.type == Type::mass_scale)
      for (Eigen::Index i = 0; i < sequence.loads.node_mass_kg.size(); ++i)
        change.load_N.col(column).segment<3>(3 * i) =
            -sequence.loads.node_mass_kg[i] * sequence.loads.gravity_m_s2;
    const auto boundary = static_cast<std::size_t>(sequence.frames[frame].boundary);
    for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
      if (!is_slipped(c, which, k, frame, parameters)) continue;
      const auto clip = static_cast<std::size_t>(sequence.forces[k].clip);
      for (const int node : sequence.boundaries[boundary].clips[clip].nodes)
        change.held_m.col(column).segment<3>(3 * static_cast<Eigen::Index>(node)) -=
            direction_of(sequence, k, frame);
    }
  }
  return change;
}

}  // namespace tenter::estimation
