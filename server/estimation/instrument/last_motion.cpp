// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/instrument/last_motion.h"

#include <algorithm>
#include <cmath>

namespace tenter::estimation {

std::vector<double> last_motions(const std::vector<double>& travel, const std::vector<bool>& starts,
                                 double least_range) {
  constexpr double kStill = 0.01;  // of the range
  const auto n = static_cast<int>(travel.size());
  std::vector<double> motion(travel.size(), 0.0);
  if (n == 0) return motion;
  const auto at = [&](int f) { return travel[static_cast<std::size_t>(f)]; };
  const auto [lo, hi] = std::minmax_element(travel.begin(), travel.end());
  const double range = *hi - *lo;
  if (range < least_range) return motion;
  const double still = kStill * range;
  const auto fill = [&](int first, int last, double sign) {
    std::fill(motion.begin() + first, motion.begin() + last, sign);
  };
  int extreme = 0;
  double sign = 0.0;
  for (int f = 0; f < n; ++f) {
    if (f == 0 || (!starts.empty() && starts[static_cast<std::size_t>(f)])) {
      extreme = f;
      sign = 0.0;
      continue;
    }
    const double gone = at(f) - at(extreme);
    if (sign == 0.0) {
      if (std::abs(gone) <= still) continue;
      sign = gone > 0.0 ? 1.0 : -1.0;
      fill(extreme, f, sign);
      extreme = f;
    } else if (gone * sign > 0.0) {
      extreme = f;
    } else if (-gone * sign > still) {
      sign = -sign;
      // a hold at the extreme is not yet the way back
      int turn = extreme;
      for (int g = extreme + 1; g < f; ++g)
        if (std::abs(at(g) - at(extreme)) <= 0.5 * still) turn = g;
      fill(turn + 1, f, sign);
      extreme = f;
    }
    motion[static_cast<std::size_t>(f)] = sign;
  }
  return motion;
}

}  // namespace tenter::estimation
