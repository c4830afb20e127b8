// SPDX-License-Identifier: Apache-2.0
// What a capture of kind "deforming_sheet" holds besides its frames: one sheet that deforms between
// clips, as cameras and load cells saw it.
//
// Material coordinates are u = weft, v = warp (thesis 3.3.1), in metres of the flat sheet at rest.
// A vertex is a place in the material; a mesh over the vertices is there where the tracker gave
// one, else the vertices are single tracked points. Positions of frame f, vertex k, coordinate c:
//
//   position_m[(f * vertex_count() + k) * coordinates + c]
//
// Poses take the frame of a clip to space, x = rotation y + position; rotations are unit
// quaternions (w, x, y, z). Clamped material is flat and as at rest: in the frame of a clip (u, v)
// lies at  grip rotation (u, v, 0) + grip position. So with the default grip a clip at the pose
// "identity" holds its material at (u, v, 0).
//
// Values, SI. Lists over frames have the frame as their slowest index.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace tenter::capture {

using Vec2 = std::array<double, 2>;
using Vec3 = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  ///< w, x, y, z; of length one

struct RigidPose {
  Vec3 position_m = {0.0, 0.0, 0.0};
  Quaternion rotation = {1.0, 0.0, 0.0, 0.0};
};

/// A rigid body that holds a part of the sheet.
struct ClipTrack {
  std::string id;  ///< letters, digits, '_'
  /// The material it clamps, one of the two: the corners of a region of the material, border
  /// included (two corners: a line), or vertices of the mesh.
  std::vector<Vec2> region_m;
  std::vector<int> vertices;
  bool is_free = false;  ///< moves under its cords and weight; else its measured pose is imposed
  double mass_kg = 0.0;
  Vec3 centre_of_mass_m = {0.0, 0.0, 0.0};  ///< in the clip's frame
  RigidPose grip;
  std::vector<RigidPose> pose;  ///< one a frame
};

/// A cord that pulls at a clip with a measured tension.
struct CordTrack {
  std::string id;
  std::string clip;
  Vec3 attachment_m = {0.0, 0.0, 0.0};  ///< in the clip's frame
  double sigma_N = 0.0;                 ///< of one reading; 0: not known
  bool may_be_missing = false;
  std::vector<double> tension_N;  ///< one a frame; NaN: not measured, where that is declared
  std::vector<Vec3> direction;    ///< one a frame, of length one: where it pulls the clip to
};

/// A table or the like that bears the sheet up to an edge: the material at the edge's coordinate
/// and beyond lies still, (u, v) at  rotation (u, v, 0) + position  of the frame's pose.
struct SupportTrack {
  std::string id;
  char along = 'u';            ///< which material coordinate the edge is given in
  bool bears_above = true;     ///< material with coordinate >= edge; else <= edge
  std::vector<double> edge_m;  ///< one a frame
  std::vector<RigidPose> pose;
};

/// Frames in which two clips are closer to each other than this are slack: the sheet sags and curls
/// between them, another way each time, so that no equilibrium is worth comparing with it.
struct SlackRule {
  std::array<std::string, 2> clips;
  double closer_than_m = 0.0;  ///< between the positions of their poses
};

struct Sheet {
  std::string name = "sheet";
  std::vector<Vec2> material_m;               ///< (u, v) of each vertex
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise in the material; may be empty
  std::vector<std::string> vertex_name;       ///< empty, or one each
  /// Corners of the whole sheet in the material, where that is more than its mesh, or where there
  /// are points only. Empty: the mesh is the sheet.
  std::vector<Vec2> outline_m;

  int coordinates = 3;             ///< 3, or 2 where the height was not measured
  std::vector<double> position_m;  ///< NaN: not seen, where that is declared
  bool may_be_missing = false;
  double sigma_m = 0.0;                    ///< standard deviation of one coordinate; 0: not known
  std::vector<double> sigma_per_vertex_m;  ///< empty, or one each

  std::vector<ClipTrack> clips;
  std::vector<CordTrack> cords;
  std::vector<SupportTrack> supports;
  std::optional<SlackRule> slack;
  Vec3 gravity_m_s2 = {0.0, 0.0, -9.81};  ///< zero: its weight does not count

  std::size_t vertex_count() const { return material_m.size(); }
  std::size_t at(std::size_t frame, std::size_t vertex) const {
    return (frame * vertex_count() + vertex) * static_cast<std::size_t>(coordinates);
  }
  const ClipTrack* find_clip(const std::string& id) const {
    for (const ClipTrack& clip : clips)
      if (clip.id == id) return &clip;
    return nullptr;
  }
  /// Between the positions of the poses of two clips that are there.
  double distance_m(const std::array<std::string, 2>& ids, std::size_t frame) const {
    const Vec3& a = find_clip(ids[0])->pose[frame].position_m;
    const Vec3& b = find_clip(ids[1])->pose[frame].position_m;
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }
  bool is_slack(std::size_t frame) const {
    return slack && distance_m(slack->clips, frame) < slack->closer_than_m;
  }
};

}  // namespace tenter::capture
