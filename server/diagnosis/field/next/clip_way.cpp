// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/next/clip_way.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace tenter::diagnosis {
namespace {

using estimation::Sequence;
using estimation::SequenceFrame;

constexpr int kFramesOfRamp = 3;
constexpr int kFramesOfHold = 3;

/// Middles of prescribed clips, then held nodes, about the middle of all; one column each.
Eigen::Matrix3Xd handles_of(const Sequence& sequence, const SequenceFrame& frame) {
  const mechanics::Boundary& boundary =
      sequence.boundaries[static_cast<std::size_t>(frame.boundary)];
  std::vector<Eigen::Vector3d> places;
  for (std::size_t c = 0; c < boundary.clips.size(); ++c) {
    if (boundary.clips[c].is_free) continue;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& place_m : boundary.clips[c].place_m)
      middle +=
          frame.clips[c].to_space(place_m) / static_cast<double>(boundary.clips[c].place_m.size());
    places.push_back(middle);
  }
  for (Eigen::Index k = 0; k < frame.held_m.cols(); ++k) places.push_back(frame.held_m.col(k));
  Eigen::Matrix3Xd handles(3, static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k)
    handles.col(static_cast<Eigen::Index>(k)) = places[k];
  if (handles.cols() > 0) handles.colwise() -= handles.rowwise().mean().eval();
  return handles;
}

mechanics::Pose between(const mechanics::Pose& from, const mechanics::Pose& to, double share) {
  mechanics::Pose pose;
  pose.position_m = from.position_m + share * (to.position_m - from.position_m);
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to.rotation * from.rotation.transpose()));
  pose.rotation = Eigen::AngleAxisd(share * turn.angle(), turn.axis()) * from.rotation;
  return pose;
}

/// Frames one after the other.
class Recorder {
 public:
  Recorder(const Sequence& like, const ClipWay& way, Sequence& sequence)
      : first_(like.frames.front()),
        farthest_(like.frames[static_cast<std::size_t>(way.farthest)]),
        reach_(way.reach),
        sequence_(sequence) {
    place(0.0, 0.0);
  }

  void step(const ExperimentStep& step) {
    const double from = at_;
    for (int k = 1; !step.is_hold && k <= kFramesOfRamp; ++k)
      place(from + (step.strain - from) * k / kFramesOfRamp,
            std::abs(step.strain - from) / step.rate_per_s / kFramesOfRamp);
    // denser at its beginning, where a relaxation shows
    for (int k = 1; step.is_hold && k <= kFramesOfHold; ++k)
      place(at_, step.seconds * (2.0 * k - 1.0) / (kFramesOfHold * kFramesOfHold));
    ++block_;
  }

 private:
  void place(double strain, double seconds) {
    at_ = strain;
    const double share = strain / reach_;
    SequenceFrame frame = first_;
    for (std::size_t c = 0; c < frame.clips.size(); ++c)
      frame.clips[c] = between(first_.clips[c], farthest_.clips[c], share);
    if (frame.held_m.cols() == farthest_.held_m.cols())
      frame.held_m += share * (farthest_.held_m - first_.held_m);
    if (!sequence_.frames.empty()) frame.start.reset();
    frame.forces_N.setZero();
    frame.scalars.setZero();
    frame.hidden_m.clear();
    frame.misread.clear();
    frame.block = block_;
    frame.duration_s = seconds;
    sequence_.frames.push_back(std::move(frame));
  }

  const SequenceFrame& first_;
  const SequenceFrame& farthest_;
  double reach_;
  Sequence& sequence_;
  double at_ = 0.0;
  int block_ = 0;
};

}  // namespace

std::optional<ClipWay> way_of(const Sequence& sequence) {
  constexpr double kLeast = 1e-4;  // no way at all
  if (sequence.frames.empty()) return std::nullopt;
  const SequenceFrame& first = sequence.frames.front();
  const Eigen::Matrix3Xd begun = handles_of(sequence, first);
  if (begun.cols() < 2) return std::nullopt;
  const double size = begun.colwise().norm().maxCoeff();
  if (!(size > 0.0)) return std::nullopt;
  ClipWay way;
  Eigen::Matrix3Xd before = begun;
  for (std::size_t f = 1; f < sequence.frames.size(); ++f) {
    const SequenceFrame& frame = sequence.frames[f];
    if (frame.boundary != first.boundary || frame.held_m.cols() != first.held_m.cols()) continue;
    const Eigen::Matrix3Xd now = handles_of(sequence, frame);
    const double reach = (now - begun).colwise().norm().maxCoeff() / size;
    if (reach > way.reach) {
      way.reach = reach;
      way.farthest = static_cast<int>(f);
    }
    if (frame.duration_s > 0.0)
      way.fastest_per_s = std::max(
          way.fastest_per_s, (now - before).colwise().norm().maxCoeff() / size / frame.duration_s);
    before = now;
  }
  if (way.reach < kLeast) return std::nullopt;
  return way;
}

Sequence sequence_of(const Experiment& plan, const Sequence& like, const ClipWay& way) {
  Sequence sequence = like;
  sequence.name = "next";
  sequence.frames.clear();
  Recorder recorder(like, way, sequence);
  for (const ExperimentStep& step : plan.steps) recorder.step(step);
  return sequence;
}

}  // namespace tenter::diagnosis
