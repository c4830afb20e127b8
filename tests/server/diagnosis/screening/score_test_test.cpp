// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screening/score_test.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "server/diagnosis/field/screen/coordinates.h"
#include "server/diagnosis/screening/normal.h"

namespace tenter::diagnosis {
namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  Normal normal(seed);
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index k = 0; k < matrix.size(); ++k) matrix.data()[k] = normal();
  return matrix;
}

constexpr Eigen::Index kRows = 120;
constexpr double kNoLeast = std::numeric_limits<double>::infinity();
const std::vector<double> kAnyAmplitudes = {-kNoLeast, -kNoLeast};

struct Case {
  Eigen::MatrixXd own = random_matrix(kRows, 3, 1);
  Eigen::MatrixXd z = random_matrix(kRows, 2, 2);
  Ground ground;

  /// Residuals in which the candidate's columns are missing with these amplitudes.
  explicit Case(const Eigen::Vector2d& amplitudes, double noise = 1.0) {
    ground.own = range_basis(own);
    ground.twins = random_matrix(kRows, 400, 3);
    ground.left = noise * random_matrix(kRows, 1, 4).col(0) - z * amplitudes;
    settle(ground);
  }
};

TEST(ScoreTest, GainIsTheFallOfALeastSquaresFit) {
  const Case c({3.0, -2.0});
  const auto tested = score_test(c.ground, c.z, kAnyAmplitudes);
  ASSERT_TRUE(tested);
  EXPECT_EQ(tested->df, 2);
  Eigen::MatrixXd all(kRows, 5);
  all << c.own, c.z;
  const Eigen::VectorXd left = c.ground.left - all * all.householderQr().solve(c.ground.left);
  const double fall = c.ground.left.squaredNorm() - left.squaredNorm();
  ASSERT_GT(fall, 100.0);
  EXPECT_NEAR(tested->gain, fall, 1e-9 * fall);
  EXPECT_GT(tested->u, 10.0);
  // what it would have to be, to the noise of one over the root of the rows
  EXPECT_NEAR(tested->amplitudes[0], 3.0, 0.4);
  EXPECT_NEAR(tested->amplitudes[1], -2.0, 0.4);
}

TEST(ScoreTest, AnAmplitudeThatCannotBeNegativeIsTestedOnOneSide) {
  for (const double amplitude : {3.0, -3.0}) {
    const Case c({amplitude, 0.0});
    const auto tested = score_test(c.ground, c.z.leftCols(1), {0.0});
    ASSERT_TRUE(tested);
    if (amplitude > 0.0)
      EXPECT_GT(tested->gain, 100.0);
    else
      EXPECT_EQ(tested->gain, 0.0);
  }
}

/// The second amplitude would be -2. Where it may not be negative the first column is left alone,
/// where it may be -1 something between.
TEST(ScoreTest, BoundsLeaveOfAGainWhatARefitCanReach) {
  const Case c({3.0, -2.0});
  const auto free = score_test(c.ground, c.z, {0.0, -kNoLeast});
  const auto bounded = score_test(c.ground, c.z, {0.0, 0.0});
  const auto partly = score_test(c.ground, c.z, {0.0, -1.0});
  const auto alone = score_test(c.ground, c.z.leftCols(1), {0.0});
  ASSERT_TRUE(free && bounded && partly && alone);
  EXPECT_EQ(free->within, free->gain);
  EXPECT_EQ(bounded->gain, free->gain);
  EXPECT_EQ(bounded->u, free->u);
  ASSERT_LT(alone->gain, 0.9 * free->gain);
  EXPECT_NEAR(bounded->within, alone->gain, 1e-9 * alone->gain);
  EXPECT_NEAR(bounded->amplitudes[0], alone->amplitudes[0], 1e-9);
  EXPECT_EQ(bounded->amplitudes[1], 0.0);
  EXPECT_GT(partly->within, bounded->within);
  EXPECT_LT(partly->within, free->within);
  EXPECT_NEAR(partly->amplitudes[1], -1.0, 1e-12);
}

TEST(ScoreTest, WhatTheModelHasIsNoCandidate) {
  const Case c({1.0, 1.0});
  EXPECT_FALSE(score_test(c.ground, c.own * random_matrix(3, 2, 9), kAnyAmplitudes));
}

TEST(ScoreTest, SpacesThatShareADirectionCorrelateWhollyOthersDoNot) {
  const Eigen::MatrixXd a = range_basis(random_matrix(kRows, 2, 5));
  const Eigen::MatrixXd b = range_basis(random_matrix(kRows, 2, 6));
  Eigen::MatrixXd with_a(kRows, 2);
  with_a << a.col(0), b.col(0);
  EXPECT_NEAR(canonical_correlation(a, range_basis(with_a)), 1.0, 1e-12);
  EXPECT_LT(canonical_correlation(a, b), 0.5);
}

/// A screen in the coordinates of what the columns span finds what one over all rows finds.
TEST(Coordinates, KeepEveryNumberOfAScoreTest) {
  const Case c({3.0, -2.0});
  Eigen::MatrixXd all(kRows, 6);
  all << c.own, c.z, c.ground.left;
  Coordinates reduced(all.cols());
  reduced.add(all.topRows(50));
  reduced.add(all.bottomRows(kRows - 50));
  const Eigen::MatrixXd& r = reduced.matrix();
  ASSERT_GT((all.transpose() * all).norm(), 100.0);
  EXPECT_LT((r.transpose() * r - all.transpose() * all).norm(),
            1e-12 * (all.transpose() * all).norm());
  Ground ground;
  ground.own = range_basis(r.leftCols(3));
  ground.left = r.col(5);
  ground.twins = random_matrix(6, 4000, 7);
  settle(ground);
  const auto small = score_test(ground, r.middleCols(3, 2), kAnyAmplitudes);
  const auto whole = score_test(c.ground, c.z, kAnyAmplitudes);
  ASSERT_TRUE(small && whole);
  EXPECT_NEAR(small->gain, whole->gain, 1e-9 * whole->gain);
  EXPECT_LT((small->amplitudes - whole->amplitudes).norm(), 1e-9);
  // noise of one sigma a row is noise of one sigma a coordinate: the 95th percentile of chi2 with
  // two degrees of freedom
  EXPECT_NEAR(small->gain / small->u, 5.99, 0.5);
}

}  // namespace
}  // namespace tenter::diagnosis
