// SPDX-License-Identifier: GPL-3.0-or-later
// Which two frames does a moment lie between? For clocks that run apart: linear between frames, and
// what the first and the last show before and after them.
//
//   r(when) = (1 - weight) r[later - 1] + weight r[later]
//   dr/dwhen = (r[later] - r[later - 1]) / span
//
// Pure; a few steps from `near`.
#pragma once

#include <optional>
#include <vector>

namespace tenter::estimation {

struct Moment {
  int later = 0;
  double weight = 0.0;  ///< 0 to 1
  double span_s = 0.0;  ///< zero before the first and after the last frame: nothing changes
};

/// Among frames [first, last) of a clock that never falls; `near`: a frame to look from. None where
/// there are fewer than two frames, or the two had no time between them.
std::optional<Moment> moment_at(const std::vector<double>& clock_s, int first, int last, int near,
                                double when_s);

}  // namespace tenter::estimation
