// SPDX-License-Identifier: GPL-3.0-or-later
// What the rig does with a square of cloth, frame after frame at rest (thesis 3.2.2): the seven
// sequences.
//
//   stretch_u, stretch_v   two bar clips on opposite sides, pulled apart and released, three loops
//                          (one where there are fewer than 18 frames)
//   shear                  picture frame of four long clips, pulled a little apart, then sheared to
//                          one side and to the other
//   bend_u, bend_v         pushed over the edge of a table and pulled back, hanging by its weight
//   complex_shear          opposite sides pulled in opposite directions: shears and buckles
//   corner_pull            four small clips: the two diagonals are pulled in turn
//
// Material coordinates (u, v) run from 0 to the side; at rest the sheet lies in z = 0 with x = u,
// y = v, gravity along -z. Clips grip up to lines of a lattice of `cells` cells: a simulated grid
// of as many cells, or a whole multiple, can have the same ones. The table's edge lies half way
// between two lines.
//
//   Protocol protocol = make_protocol(fabric("18"), "stretch_u", {.frames = 40});
//
// Pure; shares nothing with server/.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tests/twin/fabrics/fabric.h"

namespace tenter::twin {

/// A rectangle of the material, borders included.
struct Region {
  double lo_u = 0.0, hi_u = 0.0, lo_v = 0.0, hi_v = 0.0;

  bool contains(const Eigen::Vector2d& material_m, double slack_m = 1e-9) const {
    return material_m.x() >= lo_u - slack_m && material_m.x() <= hi_u + slack_m &&
           material_m.y() >= lo_v - slack_m && material_m.y() <= hi_v + slack_m;
  }
};

struct ProtocolClip {
  std::string id;
  Region grip;
  double mass_kg = 0.0;                              ///< Table 3.1
  Eigen::Vector3d pull = Eigen::Vector3d::UnitX();   ///< which way its cords lead at rest
  Eigen::Vector3d along = Eigen::Vector3d::UnitY();  ///< of a long clip, at rest
};

/// x = rotation (u, v, 0) + position.
struct ClipPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

struct ProtocolFrame {
  std::vector<ClipPose> poses;  ///< of every clip
  std::optional<Region> table;  ///< what lies on it is held
  int block = 0;                ///< branch of its loop
  double duration_s = 0.0;      ///< since the frame before, where time is told
};

struct Protocol {
  std::string name;
  double side_m = 0.1;
  int cells = 24;
  std::vector<ProtocolClip> clips;
  std::vector<ProtocolFrame> frames;
};

struct ProtocolOptions {
  int frames = 20;  ///< the thesis has 20 to 200
  int cells = 24;   ///< at least 6
};

/// Two bars on opposite sides, without frames yet. The way between their inner edges is free.
Protocol between_bars(const Fabric& fabric, bool along_u, int cells);
/// The second bar moved by so much along the pull.
std::vector<ClipPose> bar_poses(bool along_u, double way_m);

/// Four long clips, corners free: "left", "right", "bottom", "top", without frames yet.
Protocol in_picture_frame(const Fabric& fabric, int cells);
/// Stretched between the clips, and sheared by an angle of this sine.
std::vector<ClipPose> frame_poses(const Protocol& frame, double stretch_u, double stretch_v,
                                  double sine);

/// The seven, those for fits first.
std::vector<std::string> protocol_names();
Protocol make_protocol(const Fabric& fabric, const std::string& name,
                       const ProtocolOptions& options = {});

}  // namespace tenter::twin
