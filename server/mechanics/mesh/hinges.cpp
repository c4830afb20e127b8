// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/hinges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "server/mechanics/mesh/edges.h"

namespace tenter::mechanics {

namespace {

Hinge flat_hinge(const SurfaceMesh& mesh, const Edge& edge, const std::vector<double>& area) {
  const Eigen::Vector2d along = mesh.way_m(edge.low, edge.high);
  const double length = along.norm();
  const double left_weight = mesh.weight(edge.left_triangle);
  const double right_weight = mesh.weight(edge.right_triangle);
  // areas come weighted, heights are the triangle's own
  const double left = area[static_cast<std::size_t>(edge.left_triangle)] / left_weight;
  const double right = area[static_cast<std::size_t>(edge.right_triangle)] / right_weight;
  const double height = (2.0 * left / length + 2.0 * right / length) / 6.0;
  Hinge hinge;
  hinge.nodes = {edge.low, edge.high, edge.left_corner, edge.right_corner};
  hinge.rest_length_m = length;
  hinge.height_m = height;
  hinge.area_m2 = length * height * 0.5 * (left_weight + right_weight);
  hinge.bend = across(direction_of(along));
  hinge.rest_angle_rad = 0.0;
  return hinge;
}

/// Whether three points span an area that rounding does not make up.
bool spans_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double longest2 =
      std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()});
  const double area2 = (b - a).cross(c - a).norm();
  return std::isfinite(area2) && area2 > kFlattestTriangle * longest2;
}

}  // namespace

std::vector<Hinge> hinges(const SurfaceMesh& mesh) {
  const std::vector<double> area = triangle_areas_m2(mesh);
  std::vector<Hinge> found;
  for (const Edge& edge : edges(mesh))
    if (edge.interior()) found.push_back(flat_hinge(mesh, edge, area));
  return found;
}

Expected<std::vector<Hinge>> hinges(const SurfaceMesh& mesh, const Eigen::Matrix3Xd& rest_m) {
  if (rest_m.cols() != mesh.material_m.cols())
    return bad_input("rest shape: " + std::to_string(rest_m.cols()) + " positions for " +
                     std::to_string(mesh.node_count()) + " nodes");
  std::vector<Hinge> found = hinges(mesh);
  for (Hinge& hinge : found) {
    const Eigen::Vector3d from = rest_m.col(hinge.nodes[0]);
    const Eigen::Vector3d to = rest_m.col(hinge.nodes[1]);
    const Eigen::Vector3d left = rest_m.col(hinge.nodes[2]);
    const Eigen::Vector3d right = rest_m.col(hinge.nodes[3]);
    if (!spans_area(from, to, left) || !spans_area(from, to, right))
      return bad_input("rest shape: a triangle at the edge of nodes " +
                       std::to_string(hinge.nodes[0]) + " and " + std::to_string(hinge.nodes[1]) +
                       " has no area, so no angle");
    hinge.rest_angle_rad = dihedral_angle(from, to, left, right);
  }
  return found;
}

double dihedral_angle(const Eigen::Vector3d& edge_from, const Eigen::Vector3d& edge_to,
                      const Eigen::Vector3d& left, const Eigen::Vector3d& right) {
  const Eigen::Vector3d along = edge_to - edge_from;
  const Eigen::Vector3d normal_left = along.cross(left - edge_from);
  const Eigen::Vector3d normal_right = (right - edge_from).cross(along);
  const double length = along.norm();
  if (length == 0.0) return 0.0;
  // sine and cosine both carry |normal_left| |normal_right|; atan2 does not mind
  return std::atan2(along.dot(normal_left.cross(normal_right)) / length,
                    normal_left.dot(normal_right));
}

}  // namespace tenter::mechanics
