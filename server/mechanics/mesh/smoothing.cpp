// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/smoothing.h"

#include <algorithm>

#include "server/mechanics/mesh/edges.h"

namespace tenter::mechanics {

namespace {

double doubled_area(const SurfaceMesh& mesh, const std::array<int, 3>& t) {
  const Eigen::Vector2d a = mesh.material_m.col(t[1]) - mesh.material_m.col(t[0]);
  const Eigen::Vector2d b = mesh.material_m.col(t[2]) - mesh.material_m.col(t[0]);
  return a.x() * b.y() - a.y() * b.x();
}

/// Twice the area over the sum of squared sides: largest for equal sides, 0 where flat, negative
/// where flipped.
double shape(const SurfaceMesh& mesh, const std::array<int, 3>& t) {
  double sides = 0.0;
  for (std::size_t k = 0; k < 3; ++k)
    sides += (mesh.material_m.col(t[(k + 1) % 3]) - mesh.material_m.col(t[k])).squaredNorm();
  return doubled_area(mesh, t) / sides;
}

double flattest(const SurfaceMesh& mesh, const std::vector<std::size_t>& around) {
  double least = 1.0;
  for (const std::size_t t : around) least = std::min(least, shape(mesh, mesh.triangles[t]));
  return least;
}

Eigen::Vector2d centre(const SurfaceMesh& mesh, const std::vector<std::size_t>& around) {
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  double total = 0.0;
  for (const std::size_t t : around) {
    const std::array<int, 3>& c = mesh.triangles[t];
    const double area = doubled_area(mesh, c);
    total += area;
    moment += area / 3.0 *
              (mesh.material_m.col(c[0]) + mesh.material_m.col(c[1]) + mesh.material_m.col(c[2]));
  }
  return moment / total;
}

}  // namespace

void smooth(SurfaceMesh& mesh, int rounds) {
  std::vector<std::vector<std::size_t>> around(static_cast<std::size_t>(mesh.node_count()));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int node : mesh.triangles[t]) around[static_cast<std::size_t>(node)].push_back(t);
  for (const Edge& edge : edges(mesh))
    if (!edge.interior()) {
      around[static_cast<std::size_t>(edge.low)].clear();
      around[static_cast<std::size_t>(edge.high)].clear();
    }
  for (int round = 0; round < rounds; ++round)
    for (int node = 0; node < mesh.node_count(); ++node) {
      const std::vector<std::size_t>& ring = around[static_cast<std::size_t>(node)];
      if (ring.empty()) continue;
      const double before = flattest(mesh, ring);
      const Eigen::Vector2d place = mesh.material_m.col(node);
      mesh.material_m.col(node) = centre(mesh, ring);
      if (!(flattest(mesh, ring) >= before)) mesh.material_m.col(node) = place;
    }
}

}  // namespace tenter::mechanics
