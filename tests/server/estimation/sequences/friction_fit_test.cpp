// SPDX-License-Identifier: GPL-3.0-or-later
// Elasticity and friction together, from whole sequences with partial reversals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "server/estimation/fit.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/server/estimation/sequences/picture_frame.h"
#include "tests/server/estimation/whole_differences.h"

namespace tenter::estimation {
namespace {

using testing::expect_whole_differences;
using testing::measure;
using testing::picture_frame;
using testing::rubbing_cloth;
using testing::rubbing_values;

constexpr int kKnown[] = {3, 4, 5, 8};

bool is_known(int p) {
  return std::find(std::begin(kKnown), std::end(kKnown), p) != std::end(kKnown);
}

TEST(FrictionFit, TheJacobianIsThatOfTheWholePath) {
  Sequence sequence = picture_frame(7);
  const model::Model model = rubbing_cloth(rubbing_values());
  measure(sequence, model, rubbing_values(), 1.0, 1);
  const Eigen::VectorXd at = 1.1 * rubbing_values();
  auto evaluator = SequenceEvaluator::make(model, {sequence}, {2, 1e-12}).value();
  std::vector<int> unknown;
  for (int p = 0; p < evaluator.parameter_count(); ++p)
    if (!is_known(p)) unknown.push_back(p);
  expect_whole_differences(evaluator, at, unknown);

  Eigen::VectorXd residuals;
  RowMatrix jacobian;
  ASSERT_EQ(evaluator.evaluate(at, residuals, &jacobian), mechanics::PathStatus::ok);
  double cost = 0.0;
  Eigen::VectorXd gradient;
  ASSERT_EQ(evaluator.evaluate_gradient(at, cost, gradient), mechanics::PathStatus::ok);
  EXPECT_NEAR(cost, residuals.squaredNorm(), 1e-9 * cost);
  EXPECT_LT((gradient - 2.0 * (jacobian.transpose() * residuals)).norm(), 1e-9 * gradient.norm());
}

TEST(FrictionFit, ShearFrictionAndElasticityAreRecoveredTogether) {
  Sequence sequence = picture_frame(7);
  const Eigen::VectorXd truth = rubbing_values();
  measure(sequence, rubbing_cloth(truth), truth, 1.0, 3);
  Eigen::VectorXd start = truth;
  start.head<3>() << 70.0, 60.0, 14.0;
  start.tail<4>() << 0.6, 0.5, 0.0, 0.03;
  const model::Model model = rubbing_cloth(start);
  auto evaluator = SequenceEvaluator::make(model, {sequence}).value();
  const FitResult result = fit(evaluator, model, {});
  ASSERT_TRUE(result.usable && result.converged) << result.message << evaluator.failure();
  const double degrees = evaluator.row_count() - 6.0;
  EXPECT_NEAR(result.chi2 / degrees, 1.0, 5.0 * std::sqrt(2.0 / degrees));
  for (int p = 0; p < truth.size(); ++p) {
    if (is_known(p)) continue;
    EXPECT_GT(result.std_error[p], 0.0) << p;
    EXPECT_NEAR(result.parameters[p], truth[p], 4.0 * result.std_error[p]) << p;
    EXPECT_LT(result.std_error[p], 0.2 * truth[p]) << p;
  }

  // the same sequence without friction in the model: a misfit far beyond the noise
  model::Model elastic = model;
  elastic.terms.pop_back();
  auto without = SequenceEvaluator::make(elastic, {sequence}).value();
  const FitResult worse = fit(without, elastic, {});
  ASSERT_TRUE(worse.usable) << worse.message;
  EXPECT_GT(worse.chi2, 3.0 * result.chi2);
}

TEST(FrictionFit, IsTheSameToTheByteForAnyNumberOfThreads) {
  const Eigen::VectorXd truth = rubbing_values();
  std::vector<Sequence> sequences;
  for (const unsigned seed : {3U, 4U, 5U}) {
    sequences.push_back(picture_frame(5));
    measure(sequences.back(), rubbing_cloth(truth), truth, 1.0, seed);
  }
  Eigen::VectorXd at = truth;
  RowMatrix first, second;
  Eigen::VectorXd one_residual, two_residual;
  auto one = SequenceEvaluator::make(rubbing_cloth(truth), sequences, {1}).value();
  auto two = SequenceEvaluator::make(rubbing_cloth(truth), sequences, {2}).value();
  for (const double factor : {1.0, 1.2, 0.9}) {
    at = factor * truth;
    ASSERT_EQ(one.evaluate(at, one_residual, &first), mechanics::PathStatus::ok);
    ASSERT_EQ(two.evaluate(at, two_residual, &second), mechanics::PathStatus::ok);
    EXPECT_GT(one_residual.norm(), 1.0);
    EXPECT_EQ(one_residual, two_residual);
    EXPECT_EQ(first, second);
  }
}

}  // namespace
}  // namespace tenter::estimation
