// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/convexity/convex_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/model/catalogue.h"
#include "server/estimation/fit.h"
#include "tests/server/estimation/fixtures.h"

namespace tenter::estimation {
namespace {

/// A knit that is slack until its loops are straight: the weft's energy by nine control points.
model::Model slack_knit() {
  model::Model model = testing::preset_with("stvk_orthotropic", {0.0, 300.0, 30.0, 100.0});
  model::Law& weft = model.terms[0].law;
  weft.name = "hermite_energy";
  weft.range_lo = 0.0;
  weft.range_hi = 0.07;
  weft.parameters = model::default_parameters(*model::find_law(weft.name), 9);
  double slope = 0.0, energy = 0.0;
  for (std::size_t i = 1; i < weft.parameters.size(); ++i) {
    constexpr double kWidth = 0.07 / 8.0;
    slope += 20.0 * std::pow(1.8, static_cast<double>(i)) * kWidth;  // convex: less than doubling
    weft.parameters[i].value = energy += slope * kWidth;
  }
  weft.parameters[0].fixed = true;         // energies count from rest
  parameters_of(model)[11]->fixed = true;  // shear, which the loops do not show
  return model;
}

TEST(ConvexFit, StaysConvexAndLosesLessThanAProjectionAfterwards) {
  const model::Model truth = slack_knit();
  auto data = testing::data_of({testing::loop_capture({.runs = 1})}, 1.0);
  testing::measure_with(truth, 1.0, 3, *data);
  auto evaluator = Evaluator::make(truth, data).value();
  const auto constraints = ConvexityConstraints::make(truth).value();
  EXPECT_GT(constraints.worst(parameter_values(truth)).relative, -1e-9);

  const FitResult free_fit = fit(evaluator, truth, {});
  ASSERT_TRUE(free_fit.usable);
  EXPECT_LT(constraints.worst(free_fit.parameters).relative, -0.02);

  Eigen::VectorXd residuals;
  const auto projected = project_onto_convex(constraints, free_fit.parameters);
  ASSERT_EQ(projected.status, ConvexStatus::ok);
  ASSERT_EQ(evaluator.evaluate(projected.parameters, residuals, nullptr),
            mechanics::PathStatus::ok);
  const double afterwards = residuals.squaredNorm();

  const Eigen::VectorXd start = parameter_values(truth);
  const ConvexFit by_parameters =
      fit_convex(evaluator, start, constraints, {.metric = Metric::parameters});
  const ConvexFit by_data = fit_convex(evaluator, start, constraints);
  ASSERT_EQ(by_data.status, ConvexFitStatus::converged);
  EXPECT_GT(constraints.worst(by_data.parameters).relative, -1e-7);
  EXPECT_GT(constraints.worst(by_parameters.parameters).relative, -1e-7);
  EXPECT_LT(by_data.chi2, afterwards);
  EXPECT_LE(by_data.chi2, by_parameters.chi2 * (1.0 + 1e-6));
  EXPECT_GT(by_data.chi2, free_fit.chi2);
  EXPECT_EQ(by_data.parameters[11], 100.0);

  // no convex neighbour is better
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const double size : {1e-3, 1e-2, 0.1})
    for (int i = 0; i < 20; ++i) {
      Eigen::VectorXd near = by_data.parameters;
      for (Eigen::Index k = 0; k < 11; ++k)
        near[k] += k == 0 ? 0.0 : size * normal(random) * std::abs(near[k]);
      const auto convex = project_onto_convex(constraints, near);
      ASSERT_EQ(convex.status, ConvexStatus::ok);
      ASSERT_EQ(evaluator.evaluate(convex.parameters, residuals, nullptr),
                mechanics::PathStatus::ok);
      EXPECT_GT(residuals.squaredNorm(), by_data.chi2 * (1.0 - 1e-6));
    }
}

}  // namespace
}  // namespace tenter::estimation
