// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/instrument/last_motion.h"

#include <algorithm>
#include <cmath>

namespace tenter::estimation {
namespace {

constexpr double kStill = 0.01;      // of the range: no turn
constexpr double kRounding = 1e-5;   // of the range
constexpr double kDeviations = 3.0;  // of the travel's scatter

/// Standard deviation of the noise of `travel`, as far as second differences can tell.
double scatter_of(const std::vector<double>& travel) {
  std::vector<double> bend;
  for (std::size_t f = 1; f + 1 < travel.size(); ++f)
    bend.push_back(std::abs(travel[f + 1] - 2.0 * travel[f] + travel[f - 1]));
  if (bend.empty()) return 0.0;
  const auto middle = bend.begin() + static_cast<std::ptrdiff_t>(bend.size() / 2);
  std::nth_element(bend.begin(), middle, bend.end());
  return 1.4826 * *middle / std::sqrt(6.0);
}

/// The first frame of the way back from an extreme to `now`. What is within `tolerance` of the
/// extreme still stands there. Where nothing stands and both ways are straight, the turn was before
/// the extreme's own frame if the way back, prolonged, meets it and the way there does not.
int first_back(const std::vector<double>& travel, int first, int extreme, int now, int last,
               double tolerance) {
  constexpr int kStraight = 3;  // frames
  constexpr double kBent = 0.2, kMet = 0.5;
  const auto at = [&](int f) { return travel[static_cast<std::size_t>(f)]; };
  int stood = extreme;
  for (int g = extreme + 1; g < now; ++g)
    if (std::abs(at(g) - at(extreme)) <= tolerance) stood = g;
  if (stood != extreme || extreme - kStraight < first || extreme + kStraight >= last)
    return stood + 1;
  const auto bend = [&](int from, int step) {
    return std::abs(at(from) - 2.0 * at(from + step) + at(from + 2 * step));
  };
  const double off_the_way_there = bend(extreme, -1);
  const double off_the_way_back = bend(extreme, 1);
  const bool is_straight = std::max(bend(extreme - 1, -1), bend(extreme + 1, 1)) <=
                           std::max(tolerance, kBent * off_the_way_there);
  return is_straight && off_the_way_back + tolerance < kMet * off_the_way_there ? extreme
                                                                                : extreme + 1;
}

}  // namespace

std::vector<double> last_motions(const std::vector<double>& travel, const std::vector<bool>& starts,
                                 double least_range) {
  const auto n = static_cast<int>(travel.size());
  std::vector<double> motion(travel.size(), 0.0);
  if (n == 0) return motion;
  const auto at = [&](int f) { return travel[static_cast<std::size_t>(f)]; };
  const auto begins = [&](int f) {
    return f == 0 || (!starts.empty() && starts[static_cast<std::size_t>(f)]);
  };
  const auto [lo, hi] = std::minmax_element(travel.begin(), travel.end());
  const double range = *hi - *lo;
  if (range < least_range) return motion;
  const double still = kStill * range;
  const double tolerance =
      std::clamp(kDeviations * scatter_of(travel), kRounding * range, 0.5 * still);
  const auto fill = [&](int from, int to, double sign) {
    std::fill(motion.begin() + from, motion.begin() + to, sign);
  };
  int first = 0;
  int last = 0;
  int extreme = 0;
  double sign = 0.0;
  for (int f = 0; f < n; ++f) {
    if (begins(f)) {
      first = extreme = f;
      sign = 0.0;
      last = f + 1;
      while (last < n && !begins(last)) ++last;
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
      fill(first_back(travel, first, extreme, f, last, tolerance), f, sign);
      extreme = f;
    }
    motion[static_cast<std::size_t>(f)] = sign;
  }
  return motion;
}

}  // namespace tenter::estimation
