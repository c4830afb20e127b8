// SPDX-License-Identifier: GPL-3.0-or-later
// How far a point is from a triangle in space, and how far both may move before they touch.
//
//   d = |p - q|,  q = sum_j weight_j t_j the nearest point of the triangle
//   dd/dp = n,  dd/dt_j = -weight_j n,   n = (p - q)/d
//
// d has a continuous slope wherever it is not zero (a triangle is convex), whatever part of the
// triangle is nearest.
//
// Pure; no allocation.
#pragma once

#include <Eigen/Core>

namespace tenter::mechanics {

/// Columns: the point, then the three corners.
using PointAndTriangle = Eigen::Matrix<double, 3, 4>;

struct PointTriangle {
  double distance_m = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< n; zero where they touch
  Eigen::Vector3d weight = Eigen::Vector3d::Zero();  ///< of the corners, summing to one
};
PointTriangle point_triangle(const PointAndTriangle& x);

/// A share of the straight way from `from` to `to` up to which they stay apart by a tenth of their
/// first distance at least; 1 where all of it is. 0 where they touch to begin with. Never too
/// large (conservative advancement).
double free_share(const PointAndTriangle& from, const PointAndTriangle& to);

}  // namespace tenter::mechanics
