// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/crossings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "server/mechanics/contact/box_grid.h"
#include "server/mechanics/mesh/edges.h"

namespace tenter::mechanics {
namespace {

/// Six times the volume of a tetrahedron: its sign is the side of the plane of a, b, c that d is
/// on.
double volume(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
              const Eigen::Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Its ends are on different sides of the plane, and its line passes all sides the same way.
bool pierces(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& a,
             const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  if (volume(a, b, c, p) * volume(a, b, c, q) >= 0.0) return false;
  const double ab = volume(p, q, a, b), bc = volume(p, q, b, c), ca = volume(p, q, c, a);
  return (ab > 0.0 && bc > 0.0 && ca > 0.0) || (ab < 0.0 && bc < 0.0 && ca < 0.0);
}

}  // namespace

int crossings(const SurfaceMesh& mesh, const Eigen::VectorXd& x) {
  std::vector<Box> boxes;
  int first_layer = mesh.triangle_layer.empty() ? 0 : mesh.triangle_layer.front();
  for (const auto& t : mesh.triangles) {
    Box box{place_of(x, t[0]), place_of(x, t[0])};
    box.hold(place_of(x, t[1]));
    box.hold(place_of(x, t[2]));
    boxes.push_back(box);
  }
  for (const int layer : mesh.triangle_layer) first_layer = std::min(first_layer, layer);
  BoxGrid grid;
  grid.fill(boxes);
  int count = 0;
  for (const Edge& edge : edges(mesh)) {
    if (edge.layer != first_layer) continue;
    const Eigen::Vector3d p = place_of(x, edge.low), q = place_of(x, edge.high);
    grid.near(p.cwiseMin(q), p.cwiseMax(q), [&](int k) {
      const auto& t = mesh.triangles[static_cast<std::size_t>(k)];
      for (const int node : t)
        if (node == edge.low || node == edge.high) return;
      if (mesh.layer(k) != first_layer) return;
      count += pierces(p, q, place_of(x, t[0]), place_of(x, t[1]), place_of(x, t[2]));
    });
  }
  return count;
}

}  // namespace tenter::mechanics
