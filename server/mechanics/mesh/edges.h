// SPDX-License-Identifier: GPL-3.0-or-later
// Which triangles meet at an edge: what springs, hinges and the mesh check are made from.
//
// Edges are sorted by (layer, low, high), so that lists made from them are the same run after run
// and neighbours in memory are neighbours on the sheet. Cost n log n in the number of triangles.
#pragma once

#include <vector>

#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

/// One side of a triangle, seen from that triangle.
struct HalfEdge {
  int layer = 0;
  int low = 0;          ///< smaller node index
  int high = 0;         ///< larger node index
  bool rising = false;  ///< whether the triangle runs from low to high, so lies to the left of that
  int triangle = 0;
  int opposite = 0;  ///< the triangle's third corner
};

/// An edge of one layer; triangle and corner are -1 on the side where the sheet ends.
struct Edge {
  int layer = 0;
  int low = 0;
  int high = 0;
  int left_triangle = -1, left_corner = -1;    ///< left of the way from low to high
  int right_triangle = -1, right_corner = -1;  ///< right of it

  bool interior() const { return left_triangle >= 0 && right_triangle >= 0; }
};

/// All sides of all triangles, sorted by (layer, low, high, rising, triangle). Indices need not be
/// checked for more than being indices.
std::vector<HalfEdge> half_edges(const SurfaceMesh& mesh);

/// The edges of a mesh that passes check(), sorted by (layer, low, high).
std::vector<Edge> edges(const SurfaceMesh& mesh);

}  // namespace tenter::mechanics
