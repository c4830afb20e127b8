// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screen.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/diagnosis/screening/null_twins.h"
#include "tests/server/diagnosis/prepared_twin.h"

namespace tenter::diagnosis {
namespace {

using testing::white;
using testing::white_noise;
using testing::with_residuals;

class OnANullTwin : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    prepared_ = new Prepared(testing::prepared_twin({.seed = 11}, 8));
    excitation_ = new Excitation(examine(prepared_->data->curves));
  }
  static void TearDownTestSuite() {
    delete prepared_;
    delete excitation_;
  }

  static Screen screened(const Eigen::VectorXd& residuals, int twins = 200) {
    const Prepared& p = *prepared_;
    return screen(p.baseline.model, with_residuals(p.baseline.fit, residuals), p.data,
                  white(p.noise), *excitation_, {.null_twins = twins, .seed = 1});
  }

  static Prepared* prepared_;
  static Excitation* excitation_;
};
Prepared* OnANullTwin::prepared_ = nullptr;
Excitation* OnANullTwin::excitation_ = nullptr;

TEST_F(OnANullTwin, FreshWhiteNoiseRaisesTheAlarmOnceInTwenty) {
  const Eigen::Index rows = prepared_->baseline.fit.residuals.size();
  ASSERT_GT(rows, 200);
  int alarms = 0;
  int lacks = 0;
  constexpr int kTries = 20;
  for (unsigned seed = 1; seed <= kTries; ++seed) {
    const Screen result = screened(white_noise(rows, 1000 + seed));
    ASSERT_FALSE(result.candidates.empty());
    alarms += result.candidates.front().ratio > 1.0 ? 1 : 0;
    lacks += result.lack_of_fit > 1.0 ? 1 : 0;
  }
  // binomial with p = 0.05 and 20 tries: five or more in one of 400
  EXPECT_LE(alarms, 4);
  EXPECT_LE(lacks, 4);
}

TEST_F(OnANullTwin, APlantedColumnIsFound) {
  const Eigen::Index rows = prepared_->baseline.fit.residuals.size();
  const Screen quiet = screened(white_noise(rows, 5));
  int planted = 0;
  for (const char* id : {"load_cell_offset", "internal_friction", "viscosity", "plastic_set"}) {
    const Candidate* candidate = nullptr;
    for (const Candidate& c : quiet.candidates)
      if (c.effect->id == id && !candidate) candidate = &c;
    ASSERT_NE(candidate, nullptr) << id;
    ASSERT_GT(candidate->direction.norm(), 0.0) << id;
    // twelve standard deviations along what the effect would add; of the same sign, for amplitudes
    // that cannot be negative
    const Eigen::VectorXd direction = candidate->direction.normalized();
    const Screen loud = screened(white_noise(rows, 6) + 12.0 * direction);
    EXPECT_GT(loud.candidates.front().ratio, 2.0) << id;
    bool listed = false;
    for (const Candidate& c : loud.candidates)
      if (c.effect->id == id && c.ratio > 0.7 * loud.candidates.front().ratio) listed = true;
    EXPECT_TRUE(listed) << id << " is far behind " << loud.candidates.front().effect->id;
    EXPECT_NEAR(loud.candidates.front().gain, 144.0, 100.0) << id;
    ++planted;
  }
  EXPECT_EQ(planted, 4);
}

TEST_F(OnANullTwin, WhatTheModelAbsorbsIsNoFinding) {
  const Eigen::Index rows = prepared_->baseline.fit.residuals.size();
  const Eigen::VectorXd noise = white_noise(rows, 9);
  const Screen plain = screened(noise);
  const Eigen::VectorXd own = prepared_->baseline.fit.jacobian.col(0).normalized();
  const Screen moved = screened(noise + 50.0 * own);
  EXPECT_NEAR(moved.candidates.front().ratio, plain.candidates.front().ratio, 1e-6);
}

TEST_F(OnANullTwin, TheTableHasARowForEveryEffect) {
  const Screen result = screened(white_noise(prepared_->baseline.fit.residuals.size(), 9));
  ASSERT_EQ(result.table.size(), catalogue().size());
  for (const ScreenRow& row : result.table) EXPECT_FALSE(row.status.empty()) << row.effect->id;
  // chi2 of white noise is the number of rows less the model's parameters
  const auto rows = static_cast<double>(prepared_->baseline.fit.residuals.size());
  EXPECT_NEAR(result.expected_chi2, rows, 6.0 + 4.0 * std::sqrt(2.0 * rows / 200.0));
}

TEST(NullTwins, AreWhiteWithoutRepeatsAndTheRepeatsOwnWithThem) {
  std::vector<estimation::Row> rows;
  for (int b = 0; b < 10; ++b)
    for (int f = 0; f < 30; ++f) rows.push_back({0, 0, 30 * b + f, b});
  const Eigen::MatrixXd plain = null_twins(rows, {}, 200, 3);
  EXPECT_NEAR(plain.squaredNorm() / static_cast<double>(plain.size()), 1.0, 0.02);
  EXPECT_EQ(plain, null_twins(rows, {}, 200, 3));
  EXPECT_NE(plain, null_twins(rows, {}, 200, 4));
  estimation::Noise noise;
  noise.sequences = {std::vector<double>(30, 2.0)};
  const Eigen::MatrixXd drawn = null_twins(rows, noise, 50, 3);
  EXPECT_TRUE((drawn.array().abs() == 2.0).all());
  // one sign a block, either sign alike
  EXPECT_EQ(drawn(0, 0), drawn(29, 0));
  EXPECT_NEAR(drawn.mean(), 0.0, 0.4);
}

}  // namespace
}  // namespace tenter::diagnosis
