// SPDX-License-Identifier: GPL-3.0-or-later
// How far a point is from a triangle in space.
//
//   d = |p - q|,  q = sum_j w_j t_j the nearest point of the triangle
//   dd/dp = n,  dd/dt_j = -w_j n,   n = (p - q)/d
//
// d has a continuous slope wherever it is not zero (a triangle is convex), whatever part of the
// triangle is nearest.
//
// Pure; no allocation.
#pragma once

#include "server/mechanics/contact/pair.h"

namespace tenter::mechanics {

/// Columns: the point, then the three corners; weights (1, -w).
PairDistance point_triangle(const FourPoints& x);

}  // namespace tenter::mechanics
