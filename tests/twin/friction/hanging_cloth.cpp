// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/friction/hanging_cloth.h"

#include <cmath>

#include "tests/twin/random.h"

namespace tenter::twin {
namespace {

/// Force per width along the cloth as it hangs: stress times stretch.
double load_of(const FrictionSample& sample, const FrictionState& state) {
  return stress(sample, state) * std::sqrt(1.0 + 2.0 * state.strain);
}

/// On in small steps until the load is passed, then the share of the last step that reaches it.
FrictionState hung(const FrictionSample& sample, FrictionState state, double load) {
  const double side = load > load_of(sample, state) ? 1.0 : -1.0;
  const double step = side * sample.tau / 100.0;
  for (;;) {
    const FrictionState next = stepped(sample, state, step);
    if (side * (load - load_of(sample, next)) > 0.0) {
      state = next;
      continue;
    }
    double lo = 0.0;
    double hi = 1.0;
    constexpr int kHalvings = 50;
    for (int i = 0; i < kHalvings; ++i) {
      const double share = 0.5 * (lo + hi);
      const bool is_short =
          side * (load - load_of(sample, stepped(sample, state, share * step))) > 0.0;
      (is_short ? lo : hi) = share;
    }
    return stepped(sample, state, hi * step);
  }
}

}  // namespace

std::vector<HangingReading> hang(const FrictionSample& sample, const HangingPlan& plan) {
  Random noise(stream_seed(plan.seed, "hanging " + sample.name));
  std::vector<HangingReading> readings;
  FrictionState state;
  const auto read = [&](int weight, int run) {
    state = hung(sample, state, (weight + plan.dead_weight_N) / plan.side_m);
    const double length = plan.side_m * std::sqrt(1.0 + 2.0 * state.strain);
    readings.push_back({static_cast<double>(weight), length + plan.noise_m * noise.normal(), run});
  };
  for (int run = 0; run < plan.repeats; ++run) {
    read(0, run);
    for (int most = 1; most <= plan.largest_N; ++most) {
      for (int weight = 1; weight <= most; ++weight) read(weight, run);
      for (int weight = most - 1; weight >= 0; --weight) read(weight, run);
    }
  }
  return readings;
}

}  // namespace tenter::twin
