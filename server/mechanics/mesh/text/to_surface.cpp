// SPDX-License-Identifier: GPL-3.0-or-later
// From what a file says to a mesh: where material space is.
#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <utility>

#include "server/mechanics/mesh/mesh_text.h"

namespace tenter::mechanics {

namespace {

/// Sum of the triangles' doubled area vectors: the normal of a flat sheet, towards the side from
/// which its triangles run counter-clockwise.
Eigen::Vector3d summed_normal(const Eigen::Matrix3Xd& x,
                              const std::vector<std::array<int, 3>>& triangles) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::array<int, 3>& t : triangles) {
    const Eigen::Vector3d a = x.col(t[1]) - x.col(t[0]);
    const Eigen::Vector3d b = x.col(t[2]) - x.col(t[0]);
    sum += a.cross(b);
  }
  return sum;
}

}  // namespace

Expected<SurfaceMesh> material_from_positions(const Eigen::Matrix3Xd& positions_m,
                                              const std::vector<std::array<int, 3>>& triangles) {
  const auto count = static_cast<int>(positions_m.cols());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int node : triangles[t])
      if (node < 0 || node >= count)
        return bad_input("surface: triangle " + std::to_string(t) + " names node " +
                         std::to_string(node) + " of " + std::to_string(count));
  if (count == 0 || !positions_m.allFinite())
    return bad_input("surface: no positions, or some are not finite");
  const Eigen::Vector3d lowest = positions_m.rowwise().minCoeff();
  const double extent = (positions_m.rowwise().maxCoeff() - lowest).norm();
  const Eigen::Vector3d sum = summed_normal(positions_m, triangles);
  if (!(sum.norm() > kFlatness * kFlatness * extent * extent))
    return bad_input("surface: its triangles span no area, or face both ways");
  const Eigen::Vector3d normal = sum.normalized();

  const Eigen::Matrix3Xd from_lowest = positions_m.colwise() - lowest;
  const Eigen::VectorXd height = from_lowest.transpose() * normal;
  Eigen::Index farthest = 0;
  const double off = (height.array() - height.mean()).abs().maxCoeff(&farthest);
  if (!(off <= kFlatness * extent))
    return bad_input("surface: node " + std::to_string(farthest) + " is " +
                     std::to_string(1e3 * off) +
                     " mm off the plane of the others, and there are no texture coordinates to "
                     "say where it is in the material");
  const bool steep = std::abs(normal.x()) > 0.9;
  const Eigen::Vector3d axis = steep ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d u = (axis - axis.dot(normal) * normal).normalized();
  const Eigen::Vector3d v = normal.cross(u);
  Eigen::Matrix2Xd material(2, count);
  material.row(0) = u.transpose() * from_lowest;
  material.row(1) = v.transpose() * from_lowest;
  return make_surface_mesh(std::move(material), triangles);
}

Expected<SurfaceMesh> surface_mesh(const ReadMesh& read, double metres_per_texture_unit) {
  if (read.texture.cols() == 0) return material_from_positions(read.positions_m, read.triangles);
  return make_surface_mesh(read.texture * metres_per_texture_unit, read.triangles);
}

}  // namespace tenter::mechanics
