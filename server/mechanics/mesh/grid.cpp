// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/grid.h"

#include <cmath>
#include <cstdint>
#include <string>

namespace tenter::mechanics {

namespace {

/// Both triangles of cell (i, j), cut from lower left to upper right if `rising`.
void split_cell(const Grid& grid, int i, int j, bool rising, SurfaceMesh& mesh) {
  const int a = grid.node(i, j);
  const int b = grid.node(i + 1, j);
  const int c = grid.node(i + 1, j + 1);
  const int d = grid.node(i, j + 1);
  if (rising) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  } else {
    mesh.triangles.push_back({a, b, d});
    mesh.triangles.push_back({b, c, d});
  }
}

void add_layer(const Grid& grid, Diagonals diagonals, SurfaceMesh& mesh) {
  for (int j = 0; j + 1 < grid.nodes_v; ++j)
    for (int i = 0; i + 1 < grid.nodes_u; ++i) {
      const bool rising =
          diagonals == Diagonals::one || (diagonals == Diagonals::alternating && (i + j) % 2 == 0);
      split_cell(grid, i, j, rising, mesh);
    }
}

}  // namespace

Expected<void> check(const Grid& grid) {
  if (grid.nodes_u < 2 || grid.nodes_v < 2)
    return bad_input("grid: " + std::to_string(grid.nodes_u) + " x " +
                     std::to_string(grid.nodes_v) + " nodes; at least 2 x 2 are needed");
  if (static_cast<std::int64_t>(grid.nodes_u) * grid.nodes_v > kMostGridNodes)
    return bad_input("grid: " + std::to_string(grid.nodes_u) + " x " +
                     std::to_string(grid.nodes_v) + " nodes are more than " +
                     std::to_string(kMostGridNodes));
  for (const double length : {grid.length_u_m, grid.length_v_m})
    if (!std::isfinite(length) || length <= 0.0)
      return bad_input("grid: length " + std::to_string(length) + " m is not positive");
  return {};
}

Expected<SurfaceMesh> grid_mesh(const Grid& grid, Diagonals diagonals) {
  if (Expected<void> checked = check(grid); !checked) return tl::unexpected(checked.error());
  SurfaceMesh mesh;
  mesh.material_m.resize(2, grid.node_count());
  for (int j = 0; j < grid.nodes_v; ++j)
    for (int i = 0; i < grid.nodes_u; ++i)
      mesh.material_m.col(grid.node(i, j)) << grid.length_u_m * i / (grid.nodes_u - 1),
          grid.length_v_m * j / (grid.nodes_v - 1);

  if (diagonals == Diagonals::both) {
    add_layer(grid, Diagonals::one, mesh);
    mesh.triangle_layer.assign(mesh.triangles.size(), 0);
    add_layer(grid, Diagonals::other, mesh);
    mesh.triangle_layer.resize(mesh.triangles.size(), 1);
    mesh.triangle_weight.assign(mesh.triangles.size(), 0.5);
  } else {
    add_layer(grid, diagonals, mesh);
  }
  if (Expected<void> checked = check(mesh); !checked) return tl::unexpected(checked.error());
  return mesh;
}

}  // namespace tenter::mechanics
