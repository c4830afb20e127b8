// SPDX-License-Identifier: Apache-2.0
// When a motion has come to rest: the last instant at which its speed is above a bound (thesis
// 5.5: friction settles wrinkles faster).
//
//   auto rested = settling(times_s, speeds_m_s, untwisted_s, 1e-3);
//   if (rested && rested->is_settled) print(rested->time_s - untwisted_s);
//
// Speeds are v = sqrt(2 T / M) of the kinetic energy and the whole mass, or any that is not
// negative. Pure; O(samples); any thread.
#pragma once

#include <span>

#include "common/base/error.h"

namespace tenter::experiment {

struct Settling {
  bool is_settled = false;  ///< else the last sample is still above the bound
  double time_s = 0.0;      ///< where it last comes down to the bound, linear between samples; the
                            ///< last sample's where it is not settled
};

/// From `from_s` on: that itself where no later sample is above the bound. bad_input: lists of
/// different sizes or empty, times that do not rise, numbers that are none, a bound that is not
/// positive, no sample at or after from_s.
Expected<Settling> settling(std::span<const double> times_s, std::span<const double> speeds_m_s,
                            double from_s, double bound_m_s);

}  // namespace tenter::experiment
