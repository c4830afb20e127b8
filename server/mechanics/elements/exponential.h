// SPDX-License-Identifier: GPL-3.0-or-later
// exp(x) of eight numbers at once for x <= 0, to two units in the last place; below -708 it is
// exp(-708). For the sources of kernels only, as lanes.h.
//
// x = n log 2 + r with n an integer; exp(r) is a rational function with the coefficients of Cephes'
// exp (S. L. Moshier, netlib.org/cephes), and n goes into the exponent's bits.
#pragma once

#include <bit>
#include <cstdint>

#include "server/mechanics/elements/lanes.h"

namespace tenter::mechanics {

typedef std::int64_t IntegerLanes __attribute__((vector_size(kLanes * sizeof(std::int64_t))));

TENTER_INLINE Lanes exponential(const Lanes& x) {
  constexpr double kLowest = -708.0;
  constexpr double kMagic = 6755399441055744.0;  // 3 2^51: adding it rounds to an integer
  constexpr double kPerLog2 = 1.4426950408889634073599;
  constexpr double kLog2 = 6.93145751953125e-1, kLog2Rest = 1.42860682030941723212e-6;
  constexpr std::int64_t kOne = 0x3FF0000000000000;
  const Lanes lowest = kLowest + 0.0 * x;
  const Lanes y = x > lowest ? x : lowest;
  const Lanes shifted = y * kPerLog2 + kMagic;
  const Lanes n = shifted - kMagic;
  const Lanes r = (y - n * kLog2) - n * kLog2Rest;
  const Lanes z = r * r;
  const Lanes above = r * ((1.26177193074810590878e-4 * z + 3.02994407707441961300e-2) * z +
                           9.99999999999999999910e-1);
  const Lanes below = ((3.00198505138664455042e-6 * z + 2.52448340349684104192e-3) * z +
                       2.27265548208155028766e-1) *
                          z +
                      2.0;
  const Lanes fraction = 1.0 + 2.0 * (above / (below - above));
  const IntegerLanes power = (std::bit_cast<IntegerLanes>(shifted) << 52) + kOne;
  return fraction * std::bit_cast<Lanes>(power);
}

}  // namespace tenter::mechanics
