// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/tube.h"

#include <cmath>
#include <numbers>
#include <string>

namespace tenter::mechanics {

namespace {

Expected<void> check_tube(const Tube& tube, Diagonals diagonals) {
  if (tube.nodes_around < 4 || tube.nodes_along < 2)
    return bad_input("tube: " + std::to_string(tube.nodes_around) + " nodes around and " +
                     std::to_string(tube.nodes_along) + " along; at least 4 and 2 are needed");
  if (diagonals == Diagonals::alternating && tube.nodes_around % 2 != 0)
    return bad_input("tube: alternating diagonals need an even number of nodes around, not " +
                     std::to_string(tube.nodes_around));
  // the rest is as on the grid that the tube is when cut open
  return check(Grid{tube.nodes_around, tube.nodes_along, 2.0 * std::numbers::pi * tube.radius_m,
                    tube.length_m});
}

void add_covering(const Tube& tube, Diagonals diagonals, SurfaceMesh& mesh) {
  const auto node = [&tube](int i, int j) { return j * tube.nodes_around + i % tube.nodes_around; };
  for (int j = 0; j + 1 < tube.nodes_along; ++j)
    for (int i = 0; i < tube.nodes_around; ++i) {
      const int a = node(i, j), b = node(i + 1, j), c = node(i + 1, j + 1), d = node(i, j + 1);
      const bool rises =
          diagonals == Diagonals::one || (diagonals == Diagonals::alternating && (i + j) % 2 == 0);
      mesh.triangles.push_back({a, b, rises ? c : d});
      mesh.triangles.push_back({rises ? a : b, c, d});
    }
}

}  // namespace

Expected<SurfaceMesh> tube_mesh(const Tube& tube, Diagonals diagonals) {
  if (auto checked = check_tube(tube, diagonals); !checked) return tl::unexpected(checked.error());
  SurfaceMesh mesh;
  mesh.period_u_m = 2.0 * std::numbers::pi * tube.radius_m;
  mesh.material_m.resize(2, static_cast<Eigen::Index>(tube.nodes_around) * tube.nodes_along);
  for (int j = 0; j < tube.nodes_along; ++j)
    for (int i = 0; i < tube.nodes_around; ++i)
      mesh.material_m.col(j * tube.nodes_around + i) << mesh.period_u_m * i / tube.nodes_around,
          tube.length_m * j / (tube.nodes_along - 1);
  add_covering(tube, diagonals == Diagonals::both ? Diagonals::one : diagonals, mesh);
  if (diagonals == Diagonals::both) {
    mesh.triangle_layer.assign(mesh.triangles.size(), 0);
    add_covering(tube, Diagonals::other, mesh);
    mesh.triangle_layer.resize(mesh.triangles.size(), 1);
    mesh.triangle_weight.assign(mesh.triangles.size(), 0.5);
  }
  if (auto checked = check(mesh); !checked) return tl::unexpected(checked.error());
  return mesh;
}

Eigen::Matrix3Xd rolled_m(const SurfaceMesh& mesh) {
  const double radius = mesh.period_u_m / (2.0 * std::numbers::pi);
  Eigen::Matrix3Xd places(3, mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    const double angle = mesh.material_m(0, n) / radius;
    places.col(n) << radius * std::cos(angle), radius * std::sin(angle), mesh.material_m(1, n);
  }
  return places;
}

}  // namespace tenter::mechanics
