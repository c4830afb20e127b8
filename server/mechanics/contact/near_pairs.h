// SPDX-License-Identifier: GPL-3.0-or-later
// What of a surface comes near itself on a straight way: vertices and triangles, edges and edges.
// Those that share a node are left out. Where a surface is covered twice (surface_mesh.h, layers),
// edges are those of the first covering: those of the other cross them at rest.
//
//   NearPairs pairs(mesh);
//   pairs.find(from, to, reach_m);
//   for (const ContactPair& pair : pairs.list()) ...
//
// O(n + candidates). Nothing allocates once the lists have grown. The order is fixed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "server/mechanics/contact/box_grid.h"
#include "server/mechanics/contact/pair.h"
#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::mechanics {

struct ContactPair {
  PairKind kind = PairKind::vertex_and_triangle;
  std::array<int, 4> nodes{};
  double squares_m4 = 0.0;  ///< of edges: product of their squared lengths at rest
};

FourPoints pair_points(const Eigen::VectorXd& x, const ContactPair& pair);

class NearPairs {
 public:
  NearPairs() = default;
  explicit NearPairs(const SurfaceMesh& mesh);

  /// All pairs that may come within `reach_m` of each other while nodes go from `from` to `to`.
  void find(const Eigen::VectorXd& from, const Eigen::VectorXd& to, double reach_m);
  const std::vector<ContactPair>& list() const { return pairs_; }

 private:
  struct RestEdge {
    std::array<int, 2> nodes{};
    double squared_m2 = 0.0;
  };
  std::vector<std::array<int, 3>> triangles_;
  std::vector<RestEdge> edges_;
  std::vector<Box> boxes_;
  BoxGrid grid_;
  std::vector<ContactPair> pairs_;
};

}  // namespace tenter::mechanics
