// SPDX-License-Identifier: GPL-3.0-or-later
// Which vertices come near which triangles of the same surface on a straight way: sweep and prune
// of boxes along the longest side of the surface's box. Triangles of a vertex's own are left out.
//
//   NearPairs pairs(mesh);
//   pairs.find(from, to, reach_m);
//   for (const auto& pair : pairs.list()) ...
//
// O(n log n + candidates). Nothing allocates once the lists have grown. The order is fixed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

class NearPairs {
 public:
  using Pair = std::array<int, 4>;  ///< nodes: the vertex, then the corners

  NearPairs() = default;
  explicit NearPairs(const SurfaceMesh& mesh) : triangles_(mesh.triangles) {}

  /// All pairs that may come within `reach_m` of each other while nodes go from `from` to `to`.
  void find(const Eigen::VectorXd& from, const Eigen::VectorXd& to, double reach_m);
  const std::vector<Pair>& list() const { return pairs_; }

 private:
  struct Box {
    Eigen::Vector3d low, high;
    int triangle = 0;
  };
  std::vector<std::array<int, 3>> triangles_;
  std::vector<Box> boxes_;
  std::vector<Pair> pairs_;
};

}  // namespace tenter::mechanics
