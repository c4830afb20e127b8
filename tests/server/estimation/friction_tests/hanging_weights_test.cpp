// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/stretch/hanging_weights.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/twin/friction/hanging_cloth.h"

namespace tenter::estimation {
namespace {

WeightTable table_of(const twin::FrictionSample& sample, const twin::HangingPlan& plan) {
  WeightTable table;
  for (const twin::HangingReading& reading : twin::hang(sample, plan))
    table.readings.push_back({reading.weight_N, reading.length_m, reading.run});
  table.rest_length_m = table.width_m = plan.side_m;
  table.dead_weight_N = plan.dead_weight_N;
  table.length_noise_m = plan.noise_m;
  return table;
}

std::array<double, 5> truth_of(const twin::FrictionSample& s) {
  return {s.k1, s.k2, s.a, s.b, s.tau};
}

TEST(WeightTable, FindsAnchorsFromTheOrderOfTheWeights) {
  WeightTable table;
  const std::vector<double> weights = {0, 1, 0, 1, 2, 3, 2, 1, 2, 3, 0};
  for (const double weight : weights) table.readings.push_back({weight, 0.1 + 1e-3 * weight, 0});
  table.readings.push_back({0, 0.1, 1});
  table.readings.push_back({1, 0.101, 1});
  const auto places = places_of(table);
  const std::vector<int> anchors = {-1, 0, 1, 2, 2, 2, 5, 5, 7, 7, 9, -1, 11};
  const std::vector<double> signs = {0, 1, -1, 1, 1, 1, -1, -1, 1, 1, -1, 0, 1};
  ASSERT_EQ(places.size(), anchors.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(places[i].anchor, anchors[i]) << i;
    EXPECT_EQ(places[i].sign, signs[i]) << i;
  }
  EXPECT_EQ(places[1].branch, places[0].branch);
  EXPECT_EQ(places[6].branch, places[5].branch + 1);
  EXPECT_EQ(anchored_readings(table).size(), 11U);
}

TEST(WeightTable, RefusesWhatItCannotUse) {
  WeightTable table;
  EXPECT_FALSE(check(table));
  for (int i = 0; i < 10; ++i) table.readings.push_back({2.0, 0.1 + 1e-3 * i, 0});
  const auto idle = check(table);
  ASSERT_FALSE(idle);
  EXPECT_NE(idle.error().message.find("all weights are the same"), std::string::npos);
  table.readings.push_back({3.0, 0.115, 0});
  EXPECT_TRUE(check(table));
  table.readings[4].length_m = -0.1;
  const auto negative = check(table);
  ASSERT_FALSE(negative);
  EXPECT_NE(negative.error().message.find("reading 5"), std::string::npos);
  EXPECT_FALSE(fit_hanging_weights(table, "bend_v"));
}

TEST(HangingWeights, WithoutNoiseGiveBackTheTables) {
  for (const twin::FrictionSample& sample : twin::stretch_samples()) {
    WeightTable table = table_of(sample, {.noise_m = 0.0});
    table.length_noise_m = 1e-4;
    const auto found = fit_hanging_weights(table, "green_v", {.profiles = false});
    ASSERT_TRUE(found) << found.error().message;
    const auto truth = truth_of(sample);
    for (std::size_t k = 0; k < truth.size(); ++k)
      EXPECT_NEAR(found->numbers[k].value, truth[k], 1e-4 * truth[k])
          << sample.name << ' ' << found->numbers[k].name;
    // each stage of the papers' start lowers the error of the force
    for (std::size_t i = 1; i < found->start.rms_load.size(); ++i)
      EXPECT_LE(found->start.rms_load[i], found->start.rms_load[i - 1] * 1.0000001);
    EXPECT_GT(found->start.rms_load.front(), 2.0 * found->start.rms_load.back());
  }
}

TEST(HangingWeights, TellTheNoiseAndHoldTheTruth) {
  const twin::FrictionSample& sample = twin::stretch_samples().back();
  WeightTable table = table_of(sample, {.noise_m = 1e-4, .seed = 5});
  table.length_noise_m = 0.0;
  const auto found = fit_hanging_weights(table, "green_u");
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->noise, 1e-4, 0.2e-4);
  const auto truth = truth_of(sample);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const FrictionNumber& number = found->numbers[k];
    ASSERT_TRUE(number.lo && number.hi) << number.name;
    // four sigma of one seed: what an interval of two sigma may be off by
    const double centre = 0.5 * (*number.lo + *number.hi);
    EXPECT_LT(std::abs(centre - truth[k]), *number.hi - *number.lo) << number.name;
    EXPECT_LT(*number.hi - *number.lo, 0.5 * truth[k] + (k == 1 ? 4.0 : 0.0)) << number.name;
  }
}

TEST(HangingWeights, SayAWordWhereTheReadingsAreTooFarApartForTau) {
  twin::FrictionSample sample = twin::stretch_samples().front();
  sample.tau = 1e-4;
  const auto found = fit_hanging_weights(table_of(sample, {}), "green_v");
  ASSERT_TRUE(found);
  const FrictionNumber& tau = found->numbers.back();
  EXPECT_FALSE(tau.is_told);
  EXPECT_EQ(tau.words.find("not told: at most"), 0U) << tau.words;
  EXPECT_TRUE(found->numbers.front().is_told);
}

}  // namespace
}  // namespace tenter::estimation
