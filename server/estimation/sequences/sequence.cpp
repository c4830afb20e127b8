// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/sequence.h"

#include <algorithm>
#include <cmath>

#include "server/estimation/sequences/observations.h"

namespace tenter::estimation {

namespace {

Expected<void> check_boundaries(const Sequence& sequence) {
  if (sequence.boundaries.empty()) return bad_input("there is no boundary");
  const auto& first = sequence.boundaries.front().clips;
  for (std::size_t b = 0; b < sequence.boundaries.size(); ++b) {
    const mechanics::Boundary& boundary = sequence.boundaries[b];
    const std::string which =
        sequence.boundaries.size() > 1 ? "boundary " + std::to_string(b + 1) + ": " : "";
    if (auto ok = mechanics::check(boundary, sequence.cloth.mesh.node_count()); !ok)
      return bad_input(which + ok.error().message);
    const auto is_same = [](const mechanics::Clip& one, const mechanics::Clip& other) {
      return one.id == other.id;
    };
    if (!std::equal(boundary.clips.begin(), boundary.clips.end(), first.begin(), first.end(),
                    is_same))
      return bad_input(which + "its clips are not those of the first one");
  }
  return {};
}

Expected<void> check_frame(const Sequence& sequence, const SequenceFrame& frame) {
  if (frame.boundary < 0 || frame.boundary >= static_cast<int>(sequence.boundaries.size()))
    return bad_input(" is of boundary " + std::to_string(frame.boundary) + ", which there is not");
  const auto b = static_cast<std::size_t>(frame.boundary);
  const mechanics::Boundary& boundary = sequence.boundaries[b];
  if (frame.clips.size() != boundary.clips.size())
    return bad_input(" has poses for " + std::to_string(frame.clips.size()) + " of " +
                     std::to_string(boundary.clips.size()) + " clips");
  if (frame.held_m.size() > 0 &&
      frame.held_m.cols() != static_cast<Eigen::Index>(boundary.held.size()))
    return bad_input(" has places for " + std::to_string(frame.held_m.cols()) + " of " +
                     std::to_string(boundary.held.size()) + " held nodes");
  if (frame.start && frame.start->x.size() != sequence.start.x.size())
    return bad_input(" starts with " + std::to_string(frame.start->x.size() / 3) +
                     " nodes, the mesh has " + std::to_string(sequence.cloth.mesh.node_count()));
  if (frame.points_m.cols() != static_cast<Eigen::Index>(sequence.points.size()) ||
      frame.forces_N.size() != static_cast<Eigen::Index>(sequence.forces.size()) ||
      frame.scalars.size() != static_cast<Eigen::Index>(sequence.scalars.size()))
    return bad_input(" does not have one measurement a channel");
  if (frame.block < 0) return bad_input(" has a block below zero");
  if (!(frame.duration_s >= 0.0) || !std::isfinite(frame.duration_s))
    return bad_input(" has a duration that is negative or no number");
  return {};
}

}  // namespace

Expected<void> check(const Sequence& sequence) {
  const std::string name = "sequence \"" + sequence.name + "\": ";
  const int nodes = sequence.cloth.mesh.node_count();
  if (auto ok = check_boundaries(sequence); !ok) return bad_input(name + ok.error().message);
  if (!(sequence.weight >= 0.0) || !std::isfinite(sequence.weight))
    return bad_input(name + "the weight is negative or no number");
  if (sequence.start.x.size() != 3 * static_cast<Eigen::Index>(nodes))
    return bad_input(name + "the start has " + std::to_string(sequence.start.x.size() / 3) +
                     " nodes, the mesh " + std::to_string(nodes));
  if (sequence.frames.empty()) return bad_input(name + "there is no frame");
  if (auto ok = check_channels(sequence); !ok) return bad_input(name + ok.error().message);
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    if (auto ok = check_frame(sequence, sequence.frames[f]); !ok)
      return bad_input(name + "frame " + std::to_string(f + 1) + ok.error().message);
  }
  return {};
}

void prescribe(const Sequence& sequence, std::size_t frame, bool with_free_clips,
               mechanics::State& state) {
  const SequenceFrame& at = sequence.frames[frame];
  const mechanics::Boundary& boundary = sequence.boundaries[static_cast<std::size_t>(at.boundary)];
  const Eigen::VectorXd& start = at.start ? at.start->x : sequence.start.x;
  for (std::size_t k = 0; k < boundary.held.size(); ++k) {
    const auto first = 3 * static_cast<Eigen::Index>(boundary.held[k]);
    if (at.held_m.size() > 0)
      state.x.segment<3>(first) = at.held_m.col(static_cast<Eigen::Index>(k));
    else
      state.x.segment<3>(first) = start.segment<3>(first);
  }
  state.clips.resize(at.clips.size());
  for (std::size_t c = 0; c < at.clips.size(); ++c)
    if (with_free_clips || !boundary.clips[c].is_free) state.clips[c] = at.clips[c];
}

}  // namespace tenter::estimation
