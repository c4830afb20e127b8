// SPDX-License-Identifier: GPL-3.0-or-later
// Where a sheet goes through itself: edges that pierce triangles.
//
//   if (crossings(mesh, x) > 0) ...          // what keeps it apart (self_contact.h) comes too late
//
// Of a surface that is covered twice, the first covering's edges. Touching without going through
// counts or not, as rounding has it. Pure; O(n + candidates).
#pragma once

#include <Eigen/Core>

#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

/// Pairs of an edge and a triangle that share no node and have a point in common.
int crossings(const SurfaceMesh& mesh, const Eigen::VectorXd& x);

}  // namespace tenter::mechanics
