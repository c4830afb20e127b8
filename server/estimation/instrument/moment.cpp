// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/instrument/moment.h"

#include <algorithm>

namespace tenter::estimation {

std::optional<Moment> moment_at(const std::vector<double>& clock_s, int first, int last, int near,
                                double when_s) {
  if (last - first < 2) return std::nullopt;
  const auto clock = [&](int f) { return clock_s[static_cast<std::size_t>(f)]; };
  int later = std::clamp(near, first + 1, last - 1);
  while (later > first + 1 && clock(later - 1) > when_s) --later;
  while (later < last - 1 && clock(later) < when_s) ++later;
  const double span = clock(later) - clock(later - 1);
  if (!(span > 0.0)) return std::nullopt;
  const double place = (when_s - clock(later - 1)) / span;
  const double weight = std::clamp(place, 0.0, 1.0);
  return Moment{later, weight, place == weight ? span : 0.0};
}

}  // namespace tenter::estimation
