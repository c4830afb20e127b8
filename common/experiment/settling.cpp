// SPDX-License-Identifier: Apache-2.0
#include "common/experiment/settling.h"

#include <cmath>
#include <string>

namespace tenter::experiment {

Expected<Settling> settling(std::span<const double> times_s, std::span<const double> speeds_m_s,
                            double from_s, double bound_m_s) {
  if (times_s.empty() || times_s.size() != speeds_m_s.size())
    return bad_input("settling: " + std::to_string(times_s.size()) + " times, " +
                     std::to_string(speeds_m_s.size()) + " speeds");
  if (!(bound_m_s > 0.0) || !std::isfinite(bound_m_s))
    return bad_input("settling: the bound is " + std::to_string(bound_m_s) +
                     " m/s and must be positive");
  for (std::size_t k = 0; k < times_s.size(); ++k)
    if (!std::isfinite(times_s[k]) || !std::isfinite(speeds_m_s[k]) ||
        (k > 0 && !(times_s[k] > times_s[k - 1])))
      return bad_input("settling: sample " + std::to_string(k) +
                       " holds no number, or its time does not rise");
  if (!(times_s.back() >= from_s))
    return bad_input("settling: no sample after " + std::to_string(from_s) + " s");
  std::size_t end = times_s.size();  // all from here on are at rest
  while (end > 0 && times_s[end - 1] >= from_s && !(speeds_m_s[end - 1] > bound_m_s)) --end;
  if (end == 0 || times_s[end - 1] < from_s) return Settling{true, from_s};
  if (end == times_s.size()) return Settling{false, times_s.back()};
  const double high = speeds_m_s[end - 1], low = speeds_m_s[end];
  const double share = (high - bound_m_s) / (high - low);
  return Settling{true, times_s[end - 1] + share * (times_s[end] - times_s[end - 1])};
}

}  // namespace tenter::experiment
