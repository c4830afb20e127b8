// SPDX-License-Identifier: GPL-3.0-or-later
// Psi_max hidden in the pull of a small sheet: its derivative beside differences of whole solves,
// found within its error, and said to be one-sided where the pull never gets there.
#include "server/estimation/limits/limit_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/estimation/limits/limit_change.h"
#include "tests/server/estimation/sequences/bars.h"

namespace tenter::estimation {
namespace {

using testing::between_bars;
using testing::cloth_model;
using testing::true_values;

constexpr double kStrain = 0.04;  // of the warp at its limit

double true_limit() {
  return 0.5 * true_values()[1] * kStrain * kStrain;
}

/// Stretch and shear are unknown; what a pull along the warp hardly shows is known.
model::Model limited(const Eigen::VectorXd& values, double energy_max) {
  model::Model model = cloth_model(values);
  model::EnergyLimit limit;
  limit.id = "warp";
  limit.energy_max = energy_max;
  limit.unit = "J/m^2";
  for (const model::Term& term : model.terms)
    if (term.strain.name == "green_v") limit.terms = {term.id};
  model.limits = {limit};
  const auto parameters = parameters_of(model);
  for (const std::size_t known : {2u, 3u, 4u, 5u}) parameters[known]->fixed = true;
  return model;
}

/// A bar that cords pull, its force as large as `pull_N` in the last of five frames, and the places
/// of nine points with noise.
Sequence pulled(double pull_N, unsigned seed) {
  Sequence sequence = between_bars("pulled", false, {0.0, 0.003, 0.0});
  mechanics::Clip& bar = sequence.boundaries[0].clips[1];
  bar.is_free = true;
  bar.cord_place_m = {{0.02, 0.11, 0.0}, {0.09, 0.11, 0.0}};
  sequence.forces.clear();
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    const double now_N = 0.2 * pull_N * (static_cast<double>(f) + 1.0);
    sequence.frames[f].forces_N.resize(0);
    sequence.frames[f].cord_force_N = {{}, {{0.02, 0.5 * now_N, 0.0}, {0.01, 0.5 * now_N, 0.0}}};
  }
  auto exact = SequenceEvaluator::make(limited(true_values(), true_limit()), {sequence}).value();
  Eigen::VectorXd seen;
  EXPECT_EQ(exact.evaluate(true_values(), seen, nullptr), mechanics::PathStatus::ok)
      << exact.failure();
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (int r = 0; r < exact.row_count(); ++r) {
    const Row& row = exact.rows()[static_cast<std::size_t>(r)];
    sequence.frames[static_cast<std::size_t>(row.frame)].points_m(
        row.channel % 3, row.channel / 3) = (seen[r] + normal(random)) * sequence.points[0].sigma_m;
  }
  return sequence;
}

TEST(LimitFit, TheDerivativeByTheLimitFollowsWholeSolves) {
  const Sequence sequence = pulled(0.42, 3);
  const Eigen::VectorXd at = true_values();
  const SequenceOptions exact{2, 1e-12};
  const auto residuals_at = [&](double energy_max) {
    auto evaluator = SequenceEvaluator::make(limited(at, energy_max), {sequence}, exact).value();
    Eigen::VectorXd residuals;
    EXPECT_EQ(evaluator.evaluate(at, residuals, nullptr), mechanics::PathStatus::ok);
    return residuals;
  };
  const double here = true_limit();
  const model::Model model = limited(at, here);
  auto evaluator = SequenceEvaluator::make(model, {sequence}, exact).value();
  Eigen::VectorXd residuals;
  ASSERT_EQ(evaluator.evaluate(at, residuals, nullptr), mechanics::PathStatus::ok);
  const auto change = limit_change(evaluator, model, at, "warp", exact);
  ASSERT_TRUE(change) << change.error().message;
  EXPECT_GE(change->active_frames, 1);
  EXPECT_LT(change->active_frames, 5);
  EXPECT_NEAR(change->largest, here, 1e-5 * here);
  const double h = 1e-3 * here;
  const Eigen::VectorXd column = (residuals_at(here + h) - residuals_at(here - h)) / (2.0 * h);
  EXPECT_GT(column.norm() * here, 10.0);
  EXPECT_LT((change->column - column).norm(), 1e-3 * column.norm());
  const auto other = limit_change(evaluator, model, at, "none", exact);
  ASSERT_TRUE(other);
  EXPECT_EQ(other->column.norm(), 0.0);
}

TEST(LimitFit, FindsTheLimitThatWasHidden) {
  Eigen::VectorXd start = true_values();
  start.head<2>() << 60.0, 65.0;
  LimitFitOptions options;
  options.sequences.threads = 2;
  const auto found =
      fit_limit(limited(start, 0.4 * true_limit()), {pulled(0.42, 5)}, "warp", options);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->is_reached) << found->message;
  EXPECT_TRUE(found->converged);
  EXPECT_FALSE(found->at_least);
  EXPECT_GE(found->active_frames, 1);
  EXPECT_LT(found->cost, 0.5 * found->cost_without);
  EXPECT_GT(found->std_error, 0.0);
  EXPECT_LT(found->std_error, 0.05 * true_limit());  // and the data say so
  EXPECT_NEAR(found->energy_max, true_limit(), 3.0 * found->std_error);
  EXPECT_NEAR(found->elastic.parameters[1], true_values()[1], 3.0 * found->elastic.std_error[1]);
  EXPECT_GT(found->correlation[1], 0.3);  // a stretch is known, its energy through the stiffness
}

TEST(LimitFit, SaysThatTheDataNeverReachIt) {
  const Sequence sequence = pulled(0.12, 7);
  const auto found = fit_limit(limited(true_values(), 0.1 * true_limit()), {sequence}, "warp");
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_FALSE(found->is_reached);
  EXPECT_EQ(found->std_error, 0.0);
  ASSERT_TRUE(found->at_least);
  EXPECT_GT(*found->at_least, 0.05 * found->energy_max);
  EXPECT_LT(*found->at_least, found->energy_max);
  EXPECT_LT(found->energy_max, 0.9 * true_limit());
  EXPECT_NE(found->message.find("never reached"), std::string::npos) << found->message;
  EXPECT_NEAR(found->elastic.parameters[1], true_values()[1], 4.0 * found->elastic.std_error[1]);
  const auto missing = fit_limit(limited(true_values(), 1.0), {sequence}, "weft");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().message, "the model has no limit \"weft\"");
}

}  // namespace
}  // namespace tenter::estimation
