// SPDX-License-Identifier: GPL-3.0-or-later
// The angle of a vector for eight elements at once, to two units in the last place. For the sources
// of kernels only, as lanes.h.
//
// The smaller of |x| and |y| over the larger is at most one; above 0.66 the angle is taken from the
// diagonal. The rest is a rational function of degree 4 over 5 in the square, with the coefficients
// of Cephes' atan (S. L. Moshier, netlib.org/cephes).
#pragma once

#include "server/mechanics/elements/lanes.h"

namespace tenter::mechanics {

/// atan2(y, x); not a number where both are zero.
TENTER_INLINE Lanes arc_tangent(const Lanes& y, const Lanes& x) {
  constexpr double kHalfPi = 1.57079632679489661923;
  const Lanes zero = {};
  const Lanes ay = y < 0.0 ? -y : y;
  const Lanes ax = x < 0.0 ? -x : x;
  const Lanes small = ay < ax ? ay : ax;
  const Lanes large = ay < ax ? ax : ay;
  const auto is_diagonal = small > 0.66 * large;
  const Lanes t = (is_diagonal ? small - large : small) / (is_diagonal ? small + large : large);
  const Lanes z = t * t;
  const Lanes above = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
                        7.500855792314704667340e1) *
                           z -
                       1.228866684490136173410e2) *
                          z -
                      6.485021904942025371773e1;
  const Lanes below = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                        4.328810604912902668951e2) *
                           z +
                       4.853903996359136964868e2) *
                          z +
                      1.945506571482613964425e2;
  Lanes angle = t + t * (z * above / below);
  angle = is_diagonal ? 0.5 * kHalfPi + angle : angle;
  angle = ay < ax ? angle : kHalfPi - angle;
  angle = x < 0.0 ? 2.0 * kHalfPi - angle : angle;
  return y < zero ? -angle : angle;
}

}  // namespace tenter::mechanics
