// SPDX-License-Identifier: GPL-3.0-or-later
// A twin of the hanging weights of thesis 5.3.2: 0, 1, ..., n, ..., 1, 0 N with n from 1 to the
// largest, repeated without a rest, and lengths read with noise.
//
//   HangingPlan plan{.seed = 3};
//   std::vector<HangingReading> table = hang(stretch_samples()[0], plan);
#pragma once

#include <cstdint>
#include <vector>

#include "tests/twin/friction/friction_sample.h"

namespace tenter::twin {

struct HangingPlan {
  int largest_N = 6;
  int repeats = 3;
  double side_m = 0.1;          ///< of the square
  double dead_weight_N = 0.05;  ///< clip
  double noise_m = 1e-4;        ///< of a length; 0: none
  std::uint64_t seed = 1;
};

struct HangingReading {
  double weight_N = 0.0;
  double length_m = 0.0;
  int run = 0;
};

std::vector<HangingReading> hang(const FrictionSample& sample, const HangingPlan& plan);

}  // namespace tenter::twin
