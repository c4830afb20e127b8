// SPDX-License-Identifier: GPL-3.0-or-later
// Evens out the triangles of an irregular mesh without changing which nodes they join.
#pragma once

#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

/// `rounds` times, each inner node in turn goes to the area-weighted centre of the triangles around
/// it, unless that makes the flattest of them flatter. Nodes of the boundary stay. The mesh must
/// pass check() and passes it afterwards; the same input gives the same bytes. Linear in nodes.
void smooth(SurfaceMesh& mesh, int rounds);

}  // namespace tenter::mechanics
