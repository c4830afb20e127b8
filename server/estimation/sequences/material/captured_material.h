// SPDX-License-Identifier: GPL-3.0-or-later
// Private to from_capture: the simulated mesh of a captured sheet, and which of its nodes and of
// the capture's vertices a clip or a support has.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"
#include "common/capture/sheet/sheet.h"
#include "server/estimation/sequences/from_capture.h"
#include "server/mechanics/conditions/boundary.h"

namespace tenter::estimation {

inline Eigen::Vector3d vector_of(const capture::Vec3& v) {
  return {v[0], v[1], v[2]};
}
mechanics::Pose pose_of(const capture::RigidPose& pose);

/// The grid or the capture's own mesh, as cloth; a graded grid for these frames of the capture.
Expected<mechanics::Cloth> cloth_of(const capture::Sheet& sheet, const FromCaptureOptions& options,
                                    const std::vector<std::size_t>& frames, bool& is_graded);

/// Inside a region of the material or on its border, up to `close_m`.
bool contains(const std::vector<capture::Vec2>& region_m, const Eigen::Vector2d& material_m,
              double close_m);

/// Nodes of the mesh that each clip clamps. A node that two clips have is bad_input, and so is a
/// clip without nodes.
Expected<std::vector<std::vector<int>>> clamped_nodes(const capture::Sheet& sheet,
                                                      const mechanics::SurfaceMesh& mesh,
                                                      bool is_own_mesh);

/// For each vertex of the capture: is it in a clip?
std::vector<bool> vertices_in_clips(const capture::Sheet& sheet,
                                    const mechanics::SurfaceMesh& mesh);

/// Nodes that lie on a support in a frame, and where it puts them; with `clamps_at_edge` also the
/// other nodes of the triangles that its edge cuts.
struct HeldNodes {
  std::vector<int> nodes;
  Eigen::Matrix3Xd place_m;
};
HeldNodes held_nodes(const capture::Sheet& sheet, std::size_t frame,
                     const mechanics::SurfaceMesh& mesh, const std::vector<bool>& is_clamped,
                     bool clamps_at_edge);

/// `count` of the candidates, spread evenly over the material: each one the farthest from those
/// before it, beginning at the middle. In rising order.
std::vector<int> spread_evenly(const std::vector<capture::Vec2>& material_m,
                               const std::vector<int>& candidates, int count);

}  // namespace tenter::estimation
