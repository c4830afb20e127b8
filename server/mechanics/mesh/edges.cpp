// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/edges.h"

#include <algorithm>
#include <tuple>

namespace tenter::mechanics {

std::vector<HalfEdge> half_edges(const SurfaceMesh& mesh) {
  std::vector<HalfEdge> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const std::array<int, 3>& corner = mesh.triangles[static_cast<std::size_t>(t)];
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = corner[k];
      const int to = corner[(k + 1) % 3];
      sides.push_back({mesh.layer(t), std::min(from, to), std::max(from, to), from < to, t,
                       corner[(k + 2) % 3]});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.layer, a.low, a.high, a.rising, a.triangle) <
           std::tie(b.layer, b.low, b.high, b.rising, b.triangle);
  });
  return sides;
}

std::vector<Edge> edges(const SurfaceMesh& mesh) {
  std::vector<Edge> found;
  for (const HalfEdge& side : half_edges(mesh)) {
    const bool same = !found.empty() && found.back().layer == side.layer &&
                      found.back().low == side.low && found.back().high == side.high;
    if (!same) {
      found.emplace_back();
      found.back().layer = side.layer;
      found.back().low = side.low;
      found.back().high = side.high;
    }
    Edge& edge = found.back();
    (side.rising ? edge.left_triangle : edge.right_triangle) = side.triangle;
    (side.rising ? edge.left_corner : edge.right_corner) = side.opposite;
  }
  return found;
}

}  // namespace tenter::mechanics
