// SPDX-License-Identifier: GPL-3.0-or-later
// Four nodes of a surface that must not touch: a vertex and the corners of a triangle, or the ends
// of two edges; and how far both sides may move before they do.
//
//   d: the distance, dd/dx_c = weight_c n for the columns c     (point_triangle.h, edge_edge.h)
//
//   double share = free_share(PairKind::two_edges, from, to);
//
// Pure; no allocation.
#pragma once

#include <Eigen/Core>

namespace tenter::mechanics {

enum class PairKind {
  vertex_and_triangle,  ///< columns: the vertex, the corners
  two_edges             ///< columns: the ends of one, the ends of the other
};

using FourPoints = Eigen::Matrix<double, 3, 4>;

struct PairDistance {
  double distance_m = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< n, unit; zero where they touch
  Eigen::Vector4d weight = Eigen::Vector4d::Zero();  ///< their magnitudes sum to 2
};
PairDistance pair_distance(PairKind kind, const FourPoints& x);

/// A share of the straight way from `from` to `to` up to which they stay apart by a tenth of their
/// first distance at least; 1 where all of it is. 0 where they touch to begin with. Never too
/// large (conservative advancement).
double free_share(PairKind kind, const FourPoints& from, const FourPoints& to);

}  // namespace tenter::mechanics
