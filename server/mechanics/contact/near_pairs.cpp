// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/near_pairs.h"

#include <algorithm>

#include "server/mechanics/mesh/edges.h"

namespace tenter::mechanics {
namespace {

template <class Nodes>
Box box_around(const Eigen::VectorXd& from, const Eigen::VectorXd& to, const Nodes& nodes) {
  const Eigen::Vector3d first = place_of(from, nodes[0]);
  Box box{first, first};
  for (const int node : nodes) {
    box.hold(place_of(from, node));
    box.hold(place_of(to, node));
  }
  return box;
}

}  // namespace

FourPoints pair_points(const Eigen::VectorXd& x, const ContactPair& pair) {
  FourPoints result;
  for (Eigen::Index c = 0; c < 4; ++c)
    result.col(c) = place_of(x, pair.nodes[static_cast<std::size_t>(c)]);
  return result;
}

NearPairs::NearPairs(const SurfaceMesh& mesh) : triangles_(mesh.triangles) {
  int first_layer = mesh.layer(0);
  for (int t = 1; t < mesh.triangle_count(); ++t)
    first_layer = std::min(first_layer, mesh.layer(t));
  for (const Edge& edge : edges(mesh))
    if (edge.layer == first_layer)
      edges_.push_back({{edge.low, edge.high}, mesh.way_m(edge.low, edge.high).squaredNorm()});
}

void NearPairs::find(const Eigen::VectorXd& from, const Eigen::VectorXd& to, double reach_m) {
  pairs_.clear();
  boxes_.clear();
  for (const auto& triangle : triangles_) boxes_.push_back(box_around(from, to, triangle));
  grid_.fill(boxes_);
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(reach_m);
  const auto count = static_cast<int>(from.size() / 3);
  for (int v = 0; v < count; ++v) {
    const Box own = box_around(from, to, std::array{v});
    grid_.near(own.low - reach, own.high + reach, [&](int k) {
      const auto& t = triangles_[static_cast<std::size_t>(k)];
      if (t[0] == v || t[1] == v || t[2] == v) return;
      pairs_.push_back({PairKind::vertex_and_triangle, {v, t[0], t[1], t[2]}, 0.0});
    });
  }
  boxes_.clear();
  for (const RestEdge& edge : edges_) boxes_.push_back(box_around(from, to, edge.nodes));
  grid_.fill(boxes_);
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const RestEdge& own = edges_[e];
    grid_.near(boxes_[e].low - reach, boxes_[e].high + reach, [&](int k) {
      if (k <= static_cast<int>(e)) return;  // each pair once
      const RestEdge& other = edges_[static_cast<std::size_t>(k)];
      const auto& a = own.nodes;
      const auto& b = other.nodes;
      if (a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1]) return;
      pairs_.push_back(
          {PairKind::two_edges, {a[0], a[1], b[0], b[1]}, own.squared_m2 * other.squared_m2});
    });
  }
}

}  // namespace tenter::mechanics
