// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/sequence.h"

#include <cmath>

#include "server/estimation/sequences/material_location.h"

namespace tenter::estimation {

Expected<void> check(const Sequence& sequence) {
  const std::string name = "sequence \"" + sequence.name + "\": ";
  const int nodes = sequence.cloth.mesh.node_count();
  if (auto ok = mechanics::check(sequence.boundary, nodes); !ok)
    return bad_input(name + ok.error().message);
  if (sequence.start.x.size() != 3 * static_cast<Eigen::Index>(nodes))
    return bad_input(name + "the start has " + std::to_string(sequence.start.x.size() / 3) +
                     " nodes, the mesh " + std::to_string(nodes));
  if (sequence.frames.empty()) return bad_input(name + "there is no frame");
  for (std::size_t k = 0; k < sequence.points.size(); ++k) {
    const PointChannel& point = sequence.points[k];
    const std::string which = name + "point " + std::to_string(k + 1);
    if (!(point.sigma_m > 0.0) || !std::isfinite(point.sigma_m))
      return bad_input(which + " has no standard deviation above zero");
    if (!locate(sequence.cloth.mesh, point.material_m))
      return bad_input(which + " lies outside of the mesh");
  }
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    const ForceChannel& force = sequence.forces[k];
    const std::string which = name + "force " + std::to_string(k + 1);
    if (!(force.sigma_N > 0.0) || !std::isfinite(force.sigma_N))
      return bad_input(which + " has no standard deviation above zero");
    if (force.clip < 0 || force.clip >= static_cast<int>(sequence.boundary.clips.size()))
      return bad_input(which + " is of clip " + std::to_string(force.clip) +
                       ", which there is not");
    constexpr double kOff = 1e-9;
    if (!(std::abs(force.direction.norm() - 1.0) < kOff))
      return bad_input(which + " has a direction that is not of length one");
  }
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const SequenceFrame& frame = sequence.frames[f];
    const std::string which = name + "frame " + std::to_string(f + 1);
    if (frame.clips.size() != sequence.boundary.clips.size())
      return bad_input(which + " has poses for " + std::to_string(frame.clips.size()) + " of " +
                       std::to_string(sequence.boundary.clips.size()) + " clips");
    if (frame.points_m.cols() != static_cast<Eigen::Index>(sequence.points.size()) ||
        frame.forces_N.size() != static_cast<Eigen::Index>(sequence.forces.size()))
      return bad_input(which + " does not have one measurement a channel");
    if (frame.block < 0) return bad_input(which + " has a block below zero");
  }
  return {};
}

}  // namespace tenter::estimation
