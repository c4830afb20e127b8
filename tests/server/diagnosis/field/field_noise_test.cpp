// SPDX-License-Identifier: GPL-3.0-or-later
// What a capture states of its noise, beside what its readings show.
#include "server/diagnosis/field/noise/field_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "server/diagnosis/screening/normal.h"
#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

/// Of positions, where what is left of them is white and `times` what is stated.
FieldNoise::Kind shown_where_scatter_is(double times, bool is_guessed = false) {
  const testing::SheetTruth truth{.model = testing::compliant_cloth(), .protocols = {"stretch_u"}};
  FieldData data = data_of(sheets_of(truth, testing::compliant_cloth()));
  data.has_guessed_noise = {{is_guessed, is_guessed}};
  const auto at = predict_field(truth.model, data, {}, {});
  if (!at) throw std::runtime_error(at.error().message);
  Normal normal(7);
  Eigen::VectorXd residuals(static_cast<Eigen::Index>(at->rows.size()));
  for (double& r : residuals) r = times * normal();
  const FieldNoise noise = estimate_field_noise(data, at->rows, residuals);
  for (const FieldNoise::Kind& kind : noise.kinds)
    if (kind.kind == estimation::ObservationKind::position) return kind;
  throw std::runtime_error("the sheet has no positions");
}

TEST(FieldNoise, IsWhatReadingsShowWhereTheyDisagreeWithWhatIsStated) {
  for (const double times : {0.3, 3.0}) {
    const FieldNoise::Kind kind = shown_where_scatter_is(times);
    EXPECT_NEAR(kind.factor, times, 0.1 * times);
    EXPECT_EQ(kind.source, estimation::NoiseSource::scatter);
  }
}

TEST(FieldNoise, IsWhatIsStatedWhereReadingsAgreeOrWereFiltered) {
  for (const double times : {1.1, 0.02}) {
    const FieldNoise::Kind kind = shown_where_scatter_is(times);
    EXPECT_EQ(kind.factor, 1.0) << times;
    EXPECT_EQ(kind.source, estimation::NoiseSource::declared);
    EXPECT_NEAR(kind.shown, times * kind.stated, 0.1 * times * kind.stated);
  }
}

TEST(FieldNoise, IsWhatReadingsShowInPlaceOfAnyGuess) {
  for (const double times : {0.02, 1.1, 8.0}) {
    const FieldNoise::Kind kind = shown_where_scatter_is(times, true);
    EXPECT_NEAR(kind.factor, times, 0.1 * times);
    EXPECT_TRUE(kind.is_guessed);
    EXPECT_EQ(kind.source, estimation::NoiseSource::scatter);
  }
}

TEST(FieldNoise, WhatOnlyScattersIsNoiseWithinReason) {
  const testing::SheetTruth truth{.model = testing::compliant_cloth(), .protocols = {"stretch_u"}};
  const FieldData data = data_of(sheets_of(truth, testing::compliant_cloth()));
  const auto at = predict_field(truth.model, data, {}, {});
  ASSERT_TRUE(at);
  const auto is_noise = [&](double times, double bump) {
    Normal normal(3);
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(at->rows.size()));
    for (std::size_t r = 0; r < at->rows.size(); ++r)
      residuals[static_cast<Eigen::Index>(r)] =
          times * normal() + bump * std::sin(0.4 * at->rows[r].frame);
    FieldNoise noise = estimate_field_noise(data, at->rows, residuals);
    for (FieldNoise::Kind& kind : noise.kinds) kind.factor = 1.0;  // it was not taken
    return is_scatter(structure_of(data.sequences, at->rows, residuals).front(), noise);
  };
  EXPECT_TRUE(is_noise(1.6, 0.0));
  EXPECT_FALSE(is_noise(3.0, 0.0));
  EXPECT_FALSE(is_noise(1.0, 1.5));
}

}  // namespace
}  // namespace tenter::diagnosis
