// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/grid.h"

#include <algorithm>
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

Expected<void> check(const GridLines& lines) {
  const Grid size{static_cast<int>(std::min<std::size_t>(lines.u_m.size(), kMostGridNodes)),
                  static_cast<int>(std::min<std::size_t>(lines.v_m.size(), kMostGridNodes)), 1.0,
                  1.0};
  if (Expected<void> checked = check(size); !checked) return checked;
  for (const auto* along : {&lines.u_m, &lines.v_m})
    for (std::size_t k = 0; k < along->size(); ++k)
      if (!std::isfinite((*along)[k]) || (k > 0 && !((*along)[k] > (*along)[k - 1])))
        return bad_input("grid: line " + std::to_string(k + 1) + " at " +
                         std::to_string((*along)[k]) + " m does not rise");
  return {};
}

GridLines lines_of(const Grid& grid) {
  GridLines lines;
  for (int i = 0; i < grid.nodes_u; ++i)
    lines.u_m.push_back(grid.length_u_m * i / (grid.nodes_u - 1));
  for (int j = 0; j < grid.nodes_v; ++j)
    lines.v_m.push_back(grid.length_v_m * j / (grid.nodes_v - 1));
  return lines;
}

Expected<SurfaceMesh> grid_mesh(const Grid& grid, Diagonals diagonals) {
  if (Expected<void> checked = check(grid); !checked) return tl::unexpected(checked.error());
  return grid_mesh(lines_of(grid), diagonals);
}

Expected<SurfaceMesh> grid_mesh(const GridLines& lines, Diagonals diagonals) {
  if (Expected<void> checked = check(lines); !checked) return tl::unexpected(checked.error());
  const Grid grid{static_cast<int>(lines.u_m.size()), static_cast<int>(lines.v_m.size()),
                  lines.u_m.back() - lines.u_m.front(), lines.v_m.back() - lines.v_m.front()};
  SurfaceMesh mesh;
  mesh.material_m.resize(2, grid.node_count());
  for (int j = 0; j < grid.nodes_v; ++j)
    for (int i = 0; i < grid.nodes_u; ++i)
      mesh.material_m.col(grid.node(i, j)) << lines.u_m[static_cast<std::size_t>(i)],
          lines.v_m[static_cast<std::size_t>(j)];

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
