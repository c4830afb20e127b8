// SPDX-License-Identifier: GPL-3.0-or-later
// A sheet that is sewn to itself along the warp: a sleeve, the cylinders of thesis 5.5.
//
//   auto mesh = tube_mesh({64, 40, 0.04, 0.15}, Diagonals::alternating);
//   const Eigen::Matrix3Xd round_m = rolled_m(*mesh);
//
// Node (i, j) has index j * nodes_around + i and lies at u = i 2 pi radius / nodes_around, v = j dv
// in the material, flat at rest; the seam between the last and the first column is a cell like any
// other (SurfaceMesh::period_u_m). In space a tube begins as a cylinder about the z axis, u
// counter- clockwise from the x axis, normals outwards.
//
// Pure functions.
#pragma once

#include "server/mechanics/mesh/grid.h"

namespace tenter::mechanics {

struct Tube {
  int nodes_around = 0;
  int nodes_along = 0;
  double radius_m = 0.0;
  double length_m = 0.0;
};

/// bad_input: fewer than 4 nodes around or 2 along, more than kMostGridNodes, lengths that are not
/// positive, an odd number around with alternating diagonals (they would not alternate at the
/// seam), cells so slender that they fail check(SurfaceMesh).
Expected<SurfaceMesh> tube_mesh(const Tube& tube, Diagonals diagonals);

/// The cylinder of the mesh's own radius: one column a node. The mesh has a period.
Eigen::Matrix3Xd rolled_m(const SurfaceMesh& mesh);

}  // namespace tenter::mechanics
