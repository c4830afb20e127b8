// SPDX-License-Identifier: GPL-3.0-or-later
// A piece of cloth as models see it: triangles, hinges between them, and springs, over the same
// nodes. Terms take the elements that their strain measure lives on (common/model/catalogue.h).
//
//   Expected<Cloth> cloth = cloth_of_grid({25, 25, 0.1, 0.1}, Diagonals::alternating);
//
// Data; the mesh has passed check(). Pure functions.
#pragma once

#include <vector>

#include "common/base/error.h"
#include "server/mechanics/mesh/grid.h"
#include "server/mechanics/mesh/hinges.h"
#include "server/mechanics/mesh/springs.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

struct Cloth {
  SurfaceMesh mesh;
  std::vector<Hinge> hinges;
  Springs springs;
};

/// Springs along the grid's lines and both diagonals, whatever the triangles.
Expected<Cloth> cloth_of_grid(const Grid& grid, Diagonals diagonals);
Expected<Cloth> cloth_of_grid(const GridLines& lines, Diagonals diagonals);

/// Springs are the edges of the triangles. bad_input as check(mesh).
Expected<Cloth> cloth_of_mesh(SurfaceMesh mesh);

}  // namespace tenter::mechanics
