// SPDX-License-Identifier: GPL-3.0-or-later
// A frame that is shown. For the sources of SequenceSensors alone.
#pragma once

#include "server/estimation/sequences/sensors/sequence_sensors.h"

namespace tenter::estimation {

/// Const references that live for one call.
struct SequenceSensors::At {
  const Sequence& sequence;
  std::size_t which;
  std::size_t frame;
  const std::vector<Readings>& predicted;
  const Eigen::VectorXd& parameters;
  bool sensitivities;

  /// Channel of a force.
  Eigen::Index row(std::size_t force) const {
    return static_cast<Eigen::Index>(3 * sequence.points.size() + force);
  }
};

/// Of a channel of force in a frame, in space.
inline Eigen::Vector3d direction_of(const Sequence& sequence, std::size_t force,
                                    std::size_t frame) {
  const ForceChannel& channel = sequence.forces[force];
  const auto& clips = sequence.frames[frame].clips;
  if (!channel.turns_with_clip) return channel.direction;
  return clips[static_cast<std::size_t>(channel.clip)].rotation * channel.direction;
}

}  // namespace tenter::estimation
