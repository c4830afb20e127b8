// SPDX-License-Identifier: GPL-3.0-or-later
// How far two edges are from each other in space.
//
//   d = |p - q|,  p = (1 - s) a0 + s a1,  q = (1 - t) b0 + t b1 the nearest points
//   dd/dx_c = weight_c n,  n = (p - q)/d,  weights (1 - s, s, t - 1, -t)
//
// d has a continuous slope where it is not zero and the edges are not parallel: where they are,
// their nearest points jump, so that an energy of d is to be faded out by how far they are from it:
//
//   c = |(a1 - a0) x (b1 - b0)|^2
//
// Pure; no allocation.
#pragma once

#include <Eigen/Core>

#include "server/mechanics/contact/pair.h"

namespace tenter::mechanics {

/// Columns: the ends of one edge, the ends of the other.
PairDistance edge_edge(const FourPoints& x);

struct EdgeCross {
  double squared_m4 = 0.0;  ///< c
  FourPoints slope;         ///< dc/dx, m^3
};
EdgeCross edge_cross(const FourPoints& x);

}  // namespace tenter::mechanics
