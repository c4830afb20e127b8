// SPDX-License-Identifier: GPL-3.0-or-later
// What a capture states of its noise, beside what its readings show.
#include "server/diagnosis/field/noise/field_noise.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tenter::diagnosis
