// SPDX-License-Identifier: GPL-3.0-or-later
// An irregular triangulation of a piece of cloth, from its outline and the edge length that is
// wanted: against meshes whose lines run along weft and warp, it shows what the mesh does to an
// answer.
//
//   auto mesh = triangulate_outline({{0, 0}, {0.1, 0}, {0.1, 0.1}, {0, 0.1}}, 0.005);
//
// Sides are cut into equal pieces no longer than the edge length, the inside is filled by Delaunay
// refinement (CGAL 2D meshing), and inner nodes are evened out: the mean edge is close to the edge
// length. Corners of the outline stay nodes. Outline corners sharper than about 30 degrees give
// triangles as sharp as they are.
//
// The same input gives the same bytes; before the evening out nodes are numbered by (u, v),
// triangles by their nodes. Cost n log n, some 5 microseconds a node. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

/// The most nodes that an outline is cut into.
inline constexpr int kMostOutlineNodes = 1'000'000;

/// `outline_m`: corners (u, v) in order, either way round; a last point equal to the first is taken
/// as the closing of the loop. bad_input: fewer than three corners, not finite, crossing or
/// touching itself, an area below that of one equilateral triangle of the edge length, more than
/// kMostOutlineNodes nodes, or corners so sharp that a triangle degenerates.
Expected<SurfaceMesh> triangulate_outline(const std::vector<Eigen::Vector2d>& outline_m,
                                          double edge_length_m);

}  // namespace tenter::mechanics
