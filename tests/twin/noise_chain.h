// SPDX-License-Identifier: GPL-3.0-or-later
// The noise of the twins' instruments: white, correlated from frame to frame, scattered from repeat
// to repeat, quantised.
#pragma once

#include <vector>

#include "tests/twin/random.h"

namespace tenter::twin {

/// Parts of the noise of one channel, relative to each other; add_noise scales them to the total
/// asked for.
struct NoiseShares {
  double white = 0.8;
  double correlated = 0.45;  ///< first-order autoregression within a run
  double correlation = 0.6;  ///< from one frame to the next
  double run_offset = 0.2;   ///< one draw per run
  double run_gain = 0.25;    ///< one draw per run, times |reading| / largest reading
  double quantum = 0.5;      ///< step of the instrument
};

/// Only what an encoder adds.
inline constexpr NoiseShares kEncoder = {0.8, 0.0, 0.0, 0.0, 0.0, 0.5};

/// Adds noise of total standard deviation `sigma` to `readings` and quantises; `run` has one entry
/// per reading. Returns the step of the instrument (0 where sigma is 0: nothing is added).
double add_noise(const NoiseShares& shares, double sigma, const std::vector<int>& run,
                 Random& random, std::vector<double>& readings);

}  // namespace tenter::twin
