// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/protocols.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tenter::twin {

namespace {

constexpr double kSmallClip_kg = 1.9e-3, kLongClip_kg = 10.1e-3, kBarClip_kg = 13.3e-3;

/// Where a motion is that goes from 0 to 1 and back `loops` times.
struct Phase {
  double value = 0.0;
  int branch = 0;
};
Phase loop_phase(int frame, int frames, int loops) {
  const double t = 2.0 * loops * (frame + 0.5) / frames;
  const int branch = std::min(static_cast<int>(t), 2 * loops - 1);
  const double within = t - branch;
  return {branch % 2 == 0 ? within : 1.0 - within, branch};
}

ClipPose shifted(const Eigen::Vector3d& by) {
  return {Eigen::Matrix3d::Identity(), by};
}

/// Turned by the angle (rad) about z, the material place put to `target`.
ClipPose turned(double angle, const Eigen::Vector3d& place, const Eigen::Vector3d& target) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() << std::cos(angle), -std::sin(angle), std::sin(angle),
      std::cos(angle);
  return {rotation, target - rotation * place};
}

Protocol stretch(const Fabric& fabric, bool along_u, const ProtocolOptions& options) {
  Protocol p = between_bars(fabric, along_u, options.cells);
  const double farthest_m = fabric.side_m * (1.0 - 2.0 / options.cells) *
                            (along_u ? fabric.limits.stretch_u : fabric.limits.stretch_v);
  constexpr double kTaut = 0.06;  // share of the way that keeps the sheet from hanging through
  constexpr int kFewest = 18;     // with which three loops see several elongations
  for (int f = 0; f < options.frames; ++f) {
    const Phase phase = loop_phase(f, options.frames, options.frames < kFewest ? 1 : 3);
    const double way_m = farthest_m * (kTaut + (1.0 - kTaut) * phase.value);
    p.frames.push_back({bar_poses(along_u, way_m), {}, phase.branch});
  }
  return p;
}

Protocol picture_frame(const Fabric& fabric, const ProtocolOptions& options) {
  Protocol p = in_picture_frame(fabric, options.cells);
  for (int f = 0; f < options.frames; ++f) {
    const Phase phase = loop_phase(f, options.frames, 2);
    const double sine = (phase.branch < 2 ? 1.0 : -1.0) * fabric.limits.shear * phase.value;
    p.frames.push_back(
        {frame_poses(p, fabric.limits.frame_u, fabric.limits.frame_v, sine), {}, phase.branch});
  }
  return p;
}

Protocol bend(const Fabric& fabric, bool along_u, const ProtocolOptions& options) {
  Protocol p{along_u ? "bend_u" : "bend_v", fabric.side_m, options.cells, {}, {}};
  const double side = fabric.side_m;
  const int fewest = (options.cells + 3) / 4, most = (3 * options.cells) / 5;
  for (int f = 0; f < options.frames; ++f) {
    const Phase phase = loop_phase(f, options.frames, 1);
    const int over = fewest + static_cast<int>(std::lround(phase.value * (most - fewest)));
    const double edge = side * (options.cells - over + 0.5) / options.cells;
    p.frames.push_back(
        {{}, along_u ? Region{0.0, edge, 0.0, side} : Region{0.0, side, 0.0, edge}, phase.branch});
  }
  return p;
}

Protocol complex_shear(const Fabric& fabric, const ProtocolOptions& options) {
  Protocol p{"complex_shear", fabric.side_m, options.cells, {}, {}};
  const double side = fabric.side_m, depth = side / options.cells, free = side - 2.0 * depth;
  using Eigen::Vector3d;
  p.clips = {
      {"bottom", {0.0, side, 0.0, depth}, kBarClip_kg, -Vector3d::UnitX(), Vector3d::UnitX()},
      {"top", {0.0, side, side - depth, side}, kBarClip_kg, Vector3d::UnitX(), Vector3d::UnitX()}};
  constexpr double kTaut = 0.003;
  for (int f = 0; f < options.frames; ++f) {
    const Phase phase = loop_phase(f, options.frames, 1);
    const Vector3d half(0.5 * free * fabric.limits.complex_shear * phase.value, 0.5 * free * kTaut,
                        0.0);
    p.frames.push_back({{shifted(-half), shifted(half)}, {}, phase.branch});
  }
  return p;
}

Protocol corner_pull(const Fabric& fabric, const ProtocolOptions& options) {
  Protocol p{"corner_pull", fabric.side_m, options.cells, {}, {}};
  const double side = fabric.side_m, depth = side / options.cells;
  const double slant = std::sqrt(0.5);
  const auto corner = [&](const char* id, bool high_u, bool high_v) {
    const double u = high_u ? side - depth : 0.0, v = high_v ? side - depth : 0.0;
    const Eigen::Vector3d pull(high_u ? slant : -slant, high_v ? slant : -slant, 0.0);
    const Eigen::Vector3d along(-pull.y(), pull.x(), 0.0);
    p.clips.push_back({id, {u, u + depth, v, v + depth}, kSmallClip_kg, pull, along});
  };
  corner("u0_v0", false, false);
  corner("u1_v1", true, true);
  corner("u1_v0", true, false);
  corner("u0_v1", false, true);
  constexpr double kTaut = 0.1;  // share of the way at which the corners that wait are
  for (int f = 0; f < options.frames; ++f) {
    const Phase phase = loop_phase(f, options.frames, 4);
    const bool first_diagonal = (phase.branch / 2) % 2 == 0;
    const double pulled = fabric.limits.corner_m * (kTaut + (1.0 - kTaut) * phase.value);
    const double waiting = fabric.limits.corner_m * kTaut;
    ProtocolFrame frame;
    for (std::size_t c = 0; c < p.clips.size(); ++c)
      frame.poses.push_back(
          shifted(((c < 2) == first_diagonal ? pulled : waiting) * p.clips[c].pull));
    frame.block = phase.branch;
    p.frames.push_back(frame);
  }
  return p;
}

}  // namespace

Protocol between_bars(const Fabric& fabric, bool along_u, int cells) {
  Protocol p{along_u ? "stretch_u" : "stretch_v", fabric.side_m, cells, {}, {}};
  const double side = fabric.side_m, depth = side / cells;
  const Eigen::Vector3d out = along_u ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d along = along_u ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  const Region first = along_u ? Region{0.0, depth, 0.0, side} : Region{0.0, side, 0.0, depth};
  const Region second =
      along_u ? Region{side - depth, side, 0.0, side} : Region{0.0, side, side - depth, side};
  p.clips = {{"fixed", first, kBarClip_kg, -out, along},
             {"moved", second, kBarClip_kg, out, along}};
  return p;
}

std::vector<ClipPose> bar_poses(bool along_u, double way_m) {
  return {ClipPose{},
          shifted(way_m * (along_u ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY()))};
}

Protocol in_picture_frame(const Fabric& fabric, int cells) {
  Protocol p{"shear", fabric.side_m, cells, {}, {}};
  const double side = fabric.side_m, depth = side / cells;
  // corners stay free, wide enough that what happens there is not most of the force
  constexpr int kCornersASide = 6;
  const double from = depth * std::max(2, cells / kCornersASide), to = side - from;
  using Eigen::Vector3d;
  p.clips = {
      {"left", {0.0, depth, from, to}, kLongClip_kg, -Vector3d::UnitX(), Vector3d::UnitY()},
      {"right", {side - depth, side, from, to}, kLongClip_kg, Vector3d::UnitX(), Vector3d::UnitY()},
      {"bottom", {from, to, 0.0, depth}, kLongClip_kg, -Vector3d::UnitY(), Vector3d::UnitX()},
      {"top", {from, to, side - depth, side}, kLongClip_kg, Vector3d::UnitY(), Vector3d::UnitX()}};
  return p;
}

// The cloth between the clips goes to x = centre + (u - c) a_u + (v - c) a_v with a_u along x and
// a_v leaning by the angle; each is rigid and its inner middle lies where that map puts it.
std::vector<ClipPose> frame_poses(const Protocol& frame, double stretch_u, double stretch_v,
                                  double sine) {
  using Eigen::Vector3d;
  const double side = frame.side_m, depth = side / frame.cells, middle = 0.5 * side;
  const double angle = std::asin(sine);
  const Vector3d a_u = (1.0 + stretch_u) * Vector3d::UnitX();
  const Vector3d a_v = (1.0 + stretch_v) * Vector3d(std::sin(angle), std::cos(angle), 0.0);
  const Vector3d centre(middle, middle, 0.0);
  const double reach = middle - depth;
  return {turned(-angle, {depth, middle, 0.0}, centre - reach * a_u),
          turned(-angle, {side - depth, middle, 0.0}, centre + reach * a_u),
          shifted(centre - reach * a_v - Vector3d(middle, depth, 0.0)),
          shifted(centre + reach * a_v - Vector3d(middle, side - depth, 0.0))};
}

std::vector<std::string> protocol_names() {
  return {"stretch_u", "stretch_v", "shear", "bend_u", "bend_v", "complex_shear", "corner_pull"};
}

Protocol make_protocol(const Fabric& fabric, const std::string& name,
                       const ProtocolOptions& options) {
  if (options.cells < 6 || options.frames < 1) std::abort();
  if (name == "stretch_u") return stretch(fabric, true, options);
  if (name == "stretch_v") return stretch(fabric, false, options);
  if (name == "shear") return picture_frame(fabric, options);
  if (name == "bend_u") return bend(fabric, true, options);
  if (name == "bend_v") return bend(fabric, false, options);
  if (name == "complex_shear") return complex_shear(fabric, options);
  if (name == "corner_pull") return corner_pull(fabric, options);
  std::abort();
}

}  // namespace tenter::twin
