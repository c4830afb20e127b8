// SPDX-License-Identifier: GPL-3.0-or-later
// Springs between nodes: the membrane (ring 1) and the bending (ring 2) of the spring model,
// thesis 3.3.1.
//
//   eps = l / l0 - 1   (3.1)        energy = sum of area_m2 * density(eps)
//
// What a spring stands for. Springs come in four families: weft, warp and the two diagonals, d1
// (rising, angle > 0) and d2 (falling, angle < 0), as the strain measures spring_u, spring_v,
// spring_d1, spring_d2 of a material point. The springs of one family share out the whole sheet:
// their areas sum to its area, so that a homogeneous stretch has the area times the energy density
// of the material point.
//
// Regular grid, exactly:
//   ring 1 weft, warp    a spring's own length times the distance between neighbouring lines, half
//                        of it on the boundary
//   ring 1 diagonals     its cell; both diagonals of a cell stand for all of it, being two families
//   ring 2               the part of the sheet nearer to the node in the middle than to another
//                        spring's middle: a cell about it, and half a cell more towards a boundary
// Diagonals of cells that are not square are d1 and d2 by construction, at the angle that they
// have.
//
// Irregular mesh: an edge is given a third of each triangle beside it (ring 2: of the two triangles
// that it spans), then each family is scaled to sum to the sheet's area. Families are exact as
// a whole, not place by place, and an edge in a family measures the stretch at its own angle, up to
// 22.5 degrees off: springs on irregular meshes carry the bias of the mesh. For the splittings of
// a regular grid by its own edges the result is that of the grid. A family that no edge belongs to
// is empty.
#pragma once

#include <vector>

#include "common/base/error.h"
#include "server/mechanics/mesh/direction.h"
#include "server/mechanics/mesh/grid.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

struct Spring {
  int a = 0;
  int b = 0;
  double rest_length_m = 0.0;
  double area_m2 = 0.0;  ///< of the sheet that it stands for
  Direction direction = Direction::weft;
  double angle_rad = 0.0;  ///< of the line in the material, in (-pi/2, pi/2], 0 = weft
};

struct Springs {
  std::vector<Spring> ring1;
  std::vector<Spring> ring2;
};

/// Ring 1: weft, warp, d1, d2, each in the order of the nodes. Ring 2: over one node along the
/// same four lines; none along a direction with fewer than three nodes. bad_input as check(Grid).
Expected<Springs> grid_springs(const Grid& grid);

/// The same on lines of their own. Families still sum to the sheet, so what weft and warp springs
/// do in a homogeneous stretch is exact; but diagonals of slender cells lie near to an axis and
/// measure mostly stretch, and a ring-2 spring's strain depends on its length: the spring model on
/// such a grid is another material.
Expected<Springs> grid_springs(const GridLines& lines);

/// Ring 1: the edges. Ring 2: the opposite corners of each interior edge. Both sorted by (a, b),
/// a < b; what several layers of a mesh share is one spring. The mesh must pass check().
Springs mesh_springs(const SurfaceMesh& mesh);

}  // namespace tenter::mechanics
