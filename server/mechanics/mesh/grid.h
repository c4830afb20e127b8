// SPDX-License-Identifier: GPL-3.0-or-later
// The regular sheets of thesis 3.4.1: nodes in rows, quadrilaterals split into triangles.
//
//   auto mesh = grid_mesh({25, 25, 0.1, 0.1}, Diagonals::alternating);   // 100 mm square, 25 x 25
//
// Node (i, j) has index j * nodes_u + i and lies at (i du, j dv), du = length_u / (nodes_u - 1); on
// lines of their own (grid_lines.h) at (u_i, v_j). Triangles of slender cells measure stretch and
// shear as any others do, hinges a bend along the lines; but a twist K_uv turns the hinges along v
// by 3 K_uv dv / du, and diagonals flatter than 22.5 degrees count as weft or warp (direction.h).
// So grids of unlike spacings are for sheets that stay flat or bend along their lines.
#pragma once

#include <vector>

#include "common/base/error.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

struct Grid {
  int nodes_u = 0;  ///< along the weft
  int nodes_v = 0;  ///< along the warp
  double length_u_m = 0.0;
  double length_v_m = 0.0;

  int node(int i, int j) const { return j * nodes_u + i; }
  int node_count() const { return nodes_u * nodes_v; }
  double du_m() const { return length_u_m / (nodes_u - 1); }
  double dv_m() const { return length_v_m / (nodes_v - 1); }
};

/// Rising places of the lines (m), at least two along each axis.
struct GridLines {
  std::vector<double> u_m;
  std::vector<double> v_m;
};

/// Of equal spacing, from 0. The grid must pass check().
GridLines lines_of(const Grid& grid);

/// How quads are split. `both` is `one` and `other` laid over each other, each with half the
/// material: every quad is covered twice, by its two splittings, in two layers of weight 1/2 (see
/// surface_mesh.h). Its energy is the mean of the two one-sided energies for every law, so it
/// has the grid's symmetry under reflection without new nodes.
enum class Diagonals {
  one,          ///< from (i, j) to (i + 1, j + 1)
  alternating,  ///< `one` where i + j is even, `other` where it is odd
  other,        ///< from (i + 1, j) to (i, j + 1)
  both          ///< two layers: `one` and `other`
};

/// At most this many nodes: an index is an int and a system matrix has to fit somewhere.
inline constexpr int kMostGridNodes = 4'000'000;

/// bad_input unless at least 2 x 2 nodes, at most kMostGridNodes, lengths positive and finite.
Expected<void> check(const Grid& grid);

/// Triangles of a grid that passes check(); cells so slender that they fail check(SurfaceMesh) are
/// bad_input too.
Expected<SurfaceMesh> grid_mesh(const Grid& grid, Diagonals diagonals);

/// bad_input as check(GridLines): fewer than two, more than kMostGridNodes nodes, or not rising.
Expected<void> check(const GridLines& lines);
Expected<SurfaceMesh> grid_mesh(const GridLines& lines, Diagonals diagonals);

}  // namespace tenter::mechanics
