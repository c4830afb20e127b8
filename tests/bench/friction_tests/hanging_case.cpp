// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/friction_tests/hanging_case.h"

#include "server/estimation/friction_tests/stretch/hanging_weights.h"
#include "tests/twin/friction/hanging_cloth.h"

namespace tenter::bench {

namespace {

Expected<estimation::FrictionEstimate> found_in(const twin::FrictionSample& sample, int seed,
                                                bool profiles) {
  twin::HangingPlan plan;
  plan.seed = static_cast<std::uint64_t>(seed);
  estimation::WeightTable table;
  for (const twin::HangingReading& reading : twin::hang(sample, plan))
    table.readings.push_back({reading.weight_N, reading.length_m, reading.run});
  table.rest_length_m = table.width_m = plan.side_m;
  table.dead_weight_N = plan.dead_weight_N;
  table.length_noise_m = plan.noise_m;
  return fit_hanging_weights(table, "green_v", {.profiles = profiles});
}

}  // namespace

CoverageTable hanging_coverage(const twin::FrictionSample& sample, const CoverageOptions& options) {
  return covered(sample, options,
                 [&](int seed) { return found_in(sample, seed, options.profiles); });
}

}  // namespace tenter::bench
