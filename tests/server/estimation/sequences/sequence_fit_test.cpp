// SPDX-License-Identifier: GPL-3.0-or-later
// Fits to whole sequences: the Jacobian beside differences of whole solves, parameters that were
// hidden in the data, threads.
#include <gtest/gtest.h>

#include <cmath>

#include "server/estimation/fit.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "tests/server/estimation/sequences/bars.h"
#include "tests/server/estimation/whole_differences.h"

namespace tenter::estimation {
namespace {

using testing::between_bars;
using testing::cloth_model;
using testing::expect_whole_differences;
using testing::measured_sequences;
using testing::true_values;

TEST(SequenceFit, JacobianFollowsWholeSolves) {
  const Eigen::VectorXd at = 1.1 * true_values();
  auto evaluator =
      SequenceEvaluator::make(cloth_model(at), measured_sequences(3), {2, 1e-12}).value();
  EXPECT_EQ(evaluator.row_count(), 3 * 5 * (9 * 3 + 1));
  expect_whole_differences(evaluator, at, {0, 1, 2, 3, 4, 5});
}

TEST(SequenceFit, TheJacobianBySomeParametersIsThatByAllOfThem) {
  const Eigen::VectorXd at = 1.1 * true_values();
  SequenceOptions options;
  auto all = SequenceEvaluator::make(cloth_model(at), measured_sequences(3), options).value();
  options.moving = {1, 4};
  auto some = SequenceEvaluator::make(cloth_model(at), measured_sequences(3), options).value();
  Eigen::VectorXd residuals, of_some;
  RowMatrix by_all, by_some;
  ASSERT_EQ(all.evaluate(at, residuals, &by_all), mechanics::PathStatus::ok);
  ASSERT_EQ(some.evaluate(at, of_some, &by_some), mechanics::PathStatus::ok);
  EXPECT_EQ(residuals, of_some);
  EXPECT_GT(by_all.col(0).norm(), 0.0);
  for (Eigen::Index p = 0; p < at.size(); ++p) {
    if (p == 1 || p == 4)
      EXPECT_LT((by_some.col(p) - by_all.col(p)).norm(), 1e-12 * by_all.col(p).norm()) << p;
    else
      EXPECT_EQ(by_some.col(p).norm(), 0.0) << p;
  }
  // the next evaluation starts where these two move it
  Eigen::VectorXd moved = at;
  moved[1] *= 1.01;
  moved[4] *= 0.99;
  ASSERT_EQ(all.evaluate(moved, residuals, nullptr), mechanics::PathStatus::ok);
  ASSERT_EQ(some.evaluate(moved, of_some, nullptr), mechanics::PathStatus::ok);
  EXPECT_LT((residuals - of_some).norm(), 1e-5 * residuals.norm());
}

TEST(SequenceFit, FindsTheParametersThatWereHidden) {
  Eigen::VectorXd start(6);
  start << 70.0, 50.0, 15.0, 1e-4, 4e-4, 1.5e-4;
  const model::Model model = cloth_model(start);
  auto evaluator = SequenceEvaluator::make(model, measured_sequences(7), {2}).value();
  const FitResult result = fit(evaluator, model, {});
  ASSERT_TRUE(result.usable) << result.message << evaluator.failure();
  EXPECT_TRUE(result.converged) << result.message;
  const double degrees = evaluator.row_count() - 6.0;
  EXPECT_NEAR(result.chi2 / degrees, 1.0, 5.0 * std::sqrt(2.0 / degrees));
  for (int p = 0; p < 6; ++p) {
    EXPECT_NEAR(result.parameters[p], true_values()[p], 4.0 * result.std_error[p]) << p;
    if (p < 3) {
      EXPECT_LT(result.std_error[p], 0.05 * true_values()[p]) << p;  // and they say so
    }
  }
}

/// A bar that cords pull until the warp is at its energy limit: the stiffnesses are found through
/// the frames on both sides of it.
TEST(SequenceFit, FindsStiffnessesOfAMaterialWithAnEnergyLimit) {
  const auto limited = [](const Eigen::VectorXd& values) {
    model::Model model = cloth_model(values);
    model::EnergyLimit limit;
    limit.id = "warp";
    limit.energy_max = 0.5 * true_values()[1] * 0.04 * 0.04;
    limit.unit = "J/m^2";
    for (const model::Term& term : model.terms)
      if (term.strain.name == "green_v") limit.terms = {term.id};
    EXPECT_EQ(limit.terms.size(), 1u);
    model.limits = {limit};
    // what a pull along the warp hardly shows is known
    const auto parameters = parameters_of(model);
    for (const std::size_t known : {3u, 4u, 5u}) parameters[known]->fixed = true;
    return model;
  };
  Sequence sequence = between_bars("pulled", false, {0.0, 0.003, 0.0});
  mechanics::Clip& bar = sequence.boundaries[0].clips[1];
  bar.is_free = true;
  bar.cord_place_m = {{0.02, 0.11, 0.0}, {0.09, 0.11, 0.0}};
  sequence.forces.clear();
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const double pull_N = 0.12 * (static_cast<double>(f) + 1.0);
    sequence.frames[f].forces_N.resize(0);
    sequence.frames[f].cord_force_N = {{}, {{0.02, 0.5 * pull_N, 0.0}, {0.01, 0.5 * pull_N, 0.0}}};
  }
  const Eigen::VectorXd truth = true_values();
  Eigen::VectorXd seen;
  auto exact = SequenceEvaluator::make(limited(truth), {sequence}).value();
  ASSERT_EQ(exact.evaluate(truth, seen, nullptr), mechanics::PathStatus::ok) << exact.failure();
  for (int r = 0; r < exact.row_count(); ++r) {
    const Row& row = exact.rows()[static_cast<std::size_t>(r)];
    sequence.frames[static_cast<std::size_t>(row.frame)].points_m(
        row.channel % 3, row.channel / 3) = seen[r] * sequence.points[0].sigma_m;
  }
  // at the limit in the last frame, not in the first
  const auto stretch = [&](std::size_t frame) {
    return exact.states()[0][frame].clips[1].position_m.y() / 0.1;
  };
  EXPECT_LT(stretch(0), 0.025);
  EXPECT_LT(stretch(4) - stretch(3), 0.3 * (stretch(1) - stretch(0)));

  Eigen::VectorXd start = truth;
  start.head<3>() << 60.0, 60.0, 12.0;
  const model::Model model = limited(start);
  auto evaluator = SequenceEvaluator::make(model, {sequence}).value();
  const FitResult result = fit(evaluator, model, {});
  ASSERT_TRUE(result.usable && result.converged) << result.message << evaluator.failure();
  EXPECT_NEAR(result.parameters[1], truth[1], 1e-4 * truth[1]);
  EXPECT_LT(result.chi2, 1e-3);
}

/// The thesis' method beside Ceres: the same answer where it is asked for one, and with its stop at
/// 1 % one that differs by less than the noise.
TEST(SequenceFit, TheThesisOwnMethodFindsTheSame) {
  Eigen::VectorXd start(6);
  start << 70.0, 50.0, 15.0, 1e-4, 4e-4, 1.5e-4;
  const model::Model model = cloth_model(start);
  const auto fitted = [&](FitMethod method, double stop) {
    auto evaluator = SequenceEvaluator::make(model, measured_sequences(7)).value();
    FitOptions options;
    options.method = method;
    options.residual_stop = stop;
    options.tolerance = 1e-10;
    FitResult result = fit(evaluator, model, options);
    EXPECT_TRUE(result.usable && result.converged) << result.message << evaluator.failure();
    return result;
  };
  const FitResult ceres = fitted(FitMethod::trust_region, 0.0);
  for (const FitMethod method : {FitMethod::gauss_newton, FitMethod::gauss_newton_damped}) {
    const FitResult exact = fitted(method, 1e-9);
    const FitResult stopped = fitted(method, 0.01);
    EXPECT_LE(stopped.iterations, exact.iterations);
    EXPECT_LT(stopped.chi2, 1.02 * ceres.chi2);
    for (int p = 0; p < 6; ++p) {
      EXPECT_NEAR(exact.parameters[p], ceres.parameters[p], 0.01 * ceres.std_error[p]) << p;
      EXPECT_NEAR(stopped.parameters[p], ceres.parameters[p], ceres.std_error[p]) << p;
    }
  }
}

TEST(SequenceFit, IsTheSameToTheByteForAnyNumberOfThreads) {
  Eigen::VectorXd start(6);
  start << 60.0, 60.0, 12.0, 2e-4, 2e-4, 2e-4;
  const model::Model model = cloth_model(start);
  auto one = SequenceEvaluator::make(model, measured_sequences(7), {1}).value();
  auto two = SequenceEvaluator::make(model, measured_sequences(7), {2}).value();
  const FitResult first = fit(one, model, {});
  const FitResult second = fit(two, model, {});
  ASSERT_TRUE(first.usable && second.usable);
  EXPECT_EQ(first.parameters, second.parameters);
  EXPECT_EQ(first.residuals, second.residuals);
  EXPECT_EQ(first.jacobian, second.jacobian);
}

/// A step after which frames are far from their rest is refused, by the first such frame whatever
/// the threads did; where the last Jacobian was taken all is as before.
TEST(SequenceFit, GivesUpAStepThatTakesTooLong) {
  const Eigen::VectorXd at = true_values();
  Eigen::VectorXd before, after;
  RowMatrix jacobian;
  std::string why[2];
  for (const int threads : {1, 2}) {
    SequenceOptions options{threads};
    options.stepping_max_iterations = 0;
    auto evaluator =
        SequenceEvaluator::make(cloth_model(at), measured_sequences(3), options).value();
    evaluator.set_accuracy(Accuracy::stepping);
    ASSERT_EQ(evaluator.evaluate(at, before, &jacobian), mechanics::PathStatus::ok);
    ASSERT_EQ(evaluator.evaluate(2.0 * at, after, nullptr), mechanics::PathStatus::no_equilibrium);
    why[threads - 1] = evaluator.failure();
    evaluator.set_accuracy(Accuracy::exact);
    ASSERT_EQ(evaluator.evaluate(at, after, &jacobian), mechanics::PathStatus::ok);
    EXPECT_LT((after - before).norm(), 1e-5 * before.norm());
    ASSERT_EQ(evaluator.evaluate(2.0 * at, after, nullptr), mechanics::PathStatus::ok);
    EXPECT_GT((after - before).norm(), 0.1 * before.norm());
  }
  EXPECT_FALSE(why[0].empty());
  EXPECT_EQ(why[0], why[1]);
}

TEST(SequenceFit, RestsOfNearlyTheseParametersAreStartsOfFewerIterations) {
  const Eigen::VectorXd at = true_values();
  auto first = SequenceEvaluator::make(cloth_model(at), measured_sequences(3), {}).value();
  Eigen::VectorXd residuals[2];
  ASSERT_EQ(first.evaluate(at, residuals[0], nullptr), mechanics::PathStatus::ok);
  auto sequences = first.sequences();
  for (std::size_t s = 0; s < sequences.size(); ++s)
    for (std::size_t f = 0; f < sequences[s].frames.size(); ++f)
      sequences[s].frames[f].start = first.states()[s][f];
  int iterations[2];
  for (const bool is_near : {false, true}) {
    SequenceOptions options;
    options.starts_are_near = is_near;
    auto next = SequenceEvaluator::make(cloth_model(at), sequences, options).value();
    ASSERT_EQ(next.evaluate(1.05 * at, residuals[is_near], nullptr), mechanics::PathStatus::ok);
    iterations[is_near] = next.cost().iterations;
  }
  EXPECT_LT((residuals[1] - residuals[0]).norm(), 1e-5 * residuals[0].norm());
  EXPECT_LT(iterations[1], iterations[0]);
}

TEST(SequenceFit, SaysWhatDoesNotFit) {
  const model::Model model = cloth_model(true_values());
  Sequence sequence = between_bars("weft", true, {0.006, 0.0, 0.0});
  sequence.frames[2].clips.pop_back();
  const auto missing_pose = SequenceEvaluator::make(model, {sequence});
  ASSERT_FALSE(missing_pose);
  EXPECT_EQ(missing_pose.error().message, "sequence \"weft\": frame 3 has poses for 1 of 2 clips");
  sequence = between_bars("weft", true, {0.006, 0.0, 0.0});
  sequence.points[1].material_m.x() = 0.2;
  const auto outside = SequenceEvaluator::make(model, {sequence});
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().message, "sequence \"weft\": point 2 lies outside of the mesh");
}

}  // namespace
}  // namespace tenter::estimation
