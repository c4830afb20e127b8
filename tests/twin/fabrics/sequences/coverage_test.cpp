// SPDX-License-Identifier: GPL-3.0-or-later
// A few seeds of what tenter-bench-coverage does with 200: intervals hold the truth as often as
// they say, and the residual lies at the noise floor where the model's form is right.
#include "tests/twin/fabrics/sequences/coverage.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tenter::twin {
namespace {

TEST(Coverage, BandIsThatOfTheBinomialDistribution) {
  EXPECT_EQ(binomial_band(200, 0.95), (std::pair<int, int>{179, 198}));
  EXPECT_EQ(binomial_band(1, 0.5), (std::pair<int, int>{0, 1}));
}

TEST(Coverage, IntervalsOfTheWoolHoldTheTruth) {
  constexpr int kSeeds = 24;
  const Coverage result =
      coverage_of(reached_everywhere(fabric("18")), {.seeds = kSeeds, .threads = 2});
  EXPECT_EQ(result.usable, kSeeds);
  const auto [fewest, most] = binomial_band(kSeeds, 0.95);
  EXPECT_GE(fewest, 17);
  EXPECT_EQ(result.parameters.size(), 12U);
  for (const ParameterCoverage& row : result.parameters) {
    EXPECT_GE(row.held, fewest) << row.name << " " << row.mean_off << " " << row.spread;
    EXPECT_LE(row.held, most) << row.name;
    EXPECT_NEAR(row.mean_off, 0.0, 4.0 / std::sqrt(kSeeds)) << row.name;
    EXPECT_GT(row.relative_error, 1e-5) << row.name;  // the noise is felt
  }
  EXPECT_NEAR(result.chi2_per_degree, 1.0, 0.02);
}

}  // namespace
}  // namespace tenter::twin
