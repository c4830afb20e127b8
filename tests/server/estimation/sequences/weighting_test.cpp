// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/weighting.h"

#include <gtest/gtest.h>

#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/server/estimation/sequences/bars.h"

namespace tenter::estimation {
namespace {

using testing::between_bars;
using testing::cloth_model;
using testing::true_values;

/// A sequence of five frames and one of two.
std::vector<Sequence> long_and_short() {
  std::vector<Sequence> sequences = {between_bars("long", true, {0.006, 0.0, 0.0}),
                                     between_bars("short", false, {0.0, 0.006, 0.0})};
  sequences[1].frames.resize(2);
  return sequences;
}

Eigen::VectorXd weights_of(std::vector<Sequence> sequences, const Weighting& weighting,
                           std::vector<Row>* rows = nullptr) {
  SequenceOptions options;
  options.weighting = weighting;
  const auto evaluator =
      SequenceEvaluator::make(cloth_model(true_values()), std::move(sequences), options);
  EXPECT_TRUE(evaluator) << evaluator.error().message;
  if (rows) *rows = evaluator->rows();
  return evaluator->weights();
}

double sum_of(const Eigen::VectorXd& weights, const std::vector<Row>& rows, int sequence) {
  double sum = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k)
    if (rows[k].curve == sequence) sum += weights[static_cast<Eigen::Index>(k)];
  return sum;
}

TEST(Weighting, SequencesCountAlikeHoweverLong) {
  std::vector<Sequence> sequences = long_and_short();
  std::vector<Row> rows;
  Eigen::VectorXd weights = weights_of(sequences, {}, &rows);
  EXPECT_NEAR(weights.mean(), 1.0, 1e-12);
  EXPECT_NEAR(sum_of(weights, rows, 0), sum_of(weights, rows, 1), 1e-9);
  EXPECT_GT(weights.maxCoeff(), 2.0 * weights.minCoeff());
  sequences[1].weight = 3.0;
  weights = weights_of(sequences, {});
  EXPECT_NEAR(3.0 * sum_of(weights, rows, 0), sum_of(weights, rows, 1), 1e-9);
}

TEST(Weighting, ByNoiseEveryRowCountsOne) {
  const Eigen::VectorXd weights = weights_of(long_and_short(), {WeightingRule::by_noise, {}});
  EXPECT_EQ(weights.minCoeff(), 1.0);
  EXPECT_EQ(weights.maxCoeff(), 1.0);
}

TEST(Weighting, TheThesisCountsMetresAndNewtons) {
  std::vector<Row> rows;
  const std::vector<Sequence> sequences = long_and_short();
  // stretch by forces alone, bending by positions alone
  const Eigen::VectorXd weights =
      weights_of(sequences, {WeightingRule::thesis, {{0.0, 1.0}, {1.0, 1.0}}}, &rows);
  double position = 0.0, force = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double weight = weights[static_cast<Eigen::Index>(k)];
    const bool is_force = rows[k].channel == 27;
    if (rows[k].curve == 0) {
      EXPECT_EQ(weight > 0.0, is_force);
    } else {
      (is_force ? force : position) = weight;
    }
  }
  const double ratio = sequences[1].forces[0].sigma_N / sequences[1].points[0].sigma_m;
  EXPECT_NEAR(force / position, ratio * ratio, 1e-9 * ratio * ratio);
}

TEST(Weighting, SaysWhatIsMissing) {
  const auto refused =
      SequenceEvaluator::make(cloth_model(true_values()), long_and_short(),
                              {.weighting = {WeightingRule::thesis, {{0.0, 1.0}}}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "mu and lambda are given for 1 of 2 sequences");
  const auto nothing =
      SequenceEvaluator::make(cloth_model(true_values()), long_and_short(),
                              {.weighting = {WeightingRule::thesis, {{0.0, 0.0}, {0.0, 0.0}}}});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().message, "no measured value has a weight above zero");
}

}  // namespace
}  // namespace tenter::estimation
