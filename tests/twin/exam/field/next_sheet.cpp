// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/field/next_sheet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace tenter::exam {
namespace {

constexpr int kFrames = 4;  // of a ramp or hold

/// Where the middles of clips are, about the middle of all.
Eigen::Matrix3Xd middles(const twin::Protocol& protocol, const twin::ProtocolFrame& frame) {
  Eigen::Matrix3Xd at(3, static_cast<Eigen::Index>(frame.poses.size()));
  for (std::size_t c = 0; c < frame.poses.size(); ++c) {
    const twin::Region& grip = protocol.clips[c].grip;
    const Eigen::Vector3d middle(0.5 * (grip.lo_u + grip.hi_u), 0.5 * (grip.lo_v + grip.hi_v), 0.0);
    at.col(static_cast<Eigen::Index>(c)) =
        frame.poses[c].rotation * middle + frame.poses[c].position_m;
  }
  at.colwise() -= at.rowwise().mean().eval();
  return at;
}

/// The frame that is farthest from the first among those that are seen, and how far.
std::pair<int, double> farthest_of(const twin::SheetPlan& plan) {
  const auto at = [&](int f) {
    return middles(plan.path, plan.path.frames[static_cast<std::size_t>(f)]);
  };
  const Eigen::Matrix3Xd begun = at(plan.seen.front());
  std::pair<int, double> farthest = {plan.seen.front(), 0.0};
  for (const int f : plan.seen) {
    const double strain =
        (at(f) - begun).colwise().norm().maxCoeff() / begun.colwise().norm().maxCoeff();
    if (strain > farthest.second) farthest = {f, strain};
  }
  return farthest;
}

twin::ClipPose between(const twin::ClipPose& from, const twin::ClipPose& to, double share) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to.rotation * from.rotation.transpose()));
  return {Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix() * from.rotation,
          from.position_m + share * (to.position_m - from.position_m)};
}

}  // namespace

std::optional<twin::SheetPlan> planned(const diagnosis::Design& design,
                                       const twin::SheetSuite& suite) {
  const auto like = std::ranges::find(suite.plans, design.mounted_as, &twin::SheetPlan::name);
  if (like == suite.plans.end()) return std::nullopt;
  const auto [end, reach] = farthest_of(*like);
  const auto& begun = like->path.frames[static_cast<std::size_t>(like->seen.front())].poses;
  const auto& farthest = like->path.frames[static_cast<std::size_t>(end)].poses;
  twin::SheetPlan plan = *like;
  plan.name = "next_" + design.plan.name;
  plan.held_out = false;
  plan.keeps_time = true;
  plan.path.name = plan.name;
  plan.path.frames.clear();
  plan.seen.clear();
  double at = 0.0;
  int block = 0;
  const auto place = [&](double strain, double seconds) {
    at = strain;
    twin::ProtocolFrame frame;
    for (std::size_t c = 0; c < begun.size(); ++c)
      frame.poses.push_back(between(begun[c], farthest[c], strain / reach));
    frame.block = block;
    frame.duration_s = seconds;
    plan.seen.push_back(static_cast<int>(plan.path.frames.size()));
    plan.path.frames.push_back(std::move(frame));
  };
  place(0.0, 0.0);
  for (const diagnosis::ExperimentStep& step : design.plan.steps) {
    const double from = at;
    for (int k = 1; k <= kFrames; ++k)
      if (step.is_hold)
        place(from, step.seconds * (2.0 * k - 1.0) / (kFrames * kFrames));
      else
        place(from + (step.strain - from) * k / kFrames,
              std::abs(step.strain - from) / step.rate_per_s / kFrames);
    ++block;
  }
  return plan;
}

}  // namespace tenter::exam
