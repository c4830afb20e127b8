// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/prediction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/estimation/fixtures.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::estimation {
namespace {

using testing::Comparison;
using testing::difference;

const std::vector<double> kCloth = {600.0, 800.0, 150.0, 100.0};

Eigen::VectorXd residuals_of(Evaluator& evaluator, const Eigen::VectorXd& parameters) {
  Eigen::VectorXd residuals;
  EXPECT_EQ(evaluator.evaluate(parameters, residuals, nullptr), mechanics::PathStatus::ok);
  return residuals;
}

struct Case {
  std::shared_ptr<DataSet> data;
  Evaluator evaluator;
  Eigen::VectorXd parameters;
};

Case case_of(const model::Model& model, const testing::LoopPlan& plan = {}) {
  auto data = testing::data_of({testing::loop_capture(plan)}, 0.2);
  auto evaluator = Evaluator::make(model, data);
  EXPECT_TRUE(evaluator) << (evaluator ? "" : evaluator.error().message);
  return {data, std::move(*evaluator), parameter_values(model)};
}

void check_jacobian(const model::Model& model, const testing::LoopPlan& plan,
                    const std::string& words) {
  Case c = case_of(model, plan);
  Eigen::VectorXd residuals;
  RowMatrix jacobian;
  ASSERT_EQ(c.evaluator.evaluate(c.parameters, residuals, &jacobian), mechanics::PathStatus::ok);
  const std::vector<const model::Parameter*> parameters = parameters_of(model);
  for (Eigen::Index k = 0; k < c.parameters.size(); ++k) {
    if (parameters[static_cast<std::size_t>(k)]->fixed) continue;
    const double unit = std::max(std::abs(c.parameters[k]), 1e-2);
    const auto moved = [&](double x) {
      Eigen::VectorXd p = c.parameters;
      p[k] = x;
      return residuals_of(c.evaluator, p);
    };
    const Eigen::VectorXd oracle = difference(moved, c.parameters[k], 1e-4 * unit);
    Comparison compared(words + ", parameter " + std::to_string(k));
    for (Eigen::Index r = 0; r < oracle.size(); ++r)
      compared.add(jacobian(r, k) * unit, oracle[r] * unit);
    compared.judge(1e-6, 0.0, 1e-8);
    EXPECT_GT(compared.scale(), k == 3 ? -1.0 : 1e-3) << words << ", parameter " << k;  // no shear
  }
}

TEST(Prediction, JacobianIsThatOfTheResiduals) {
  const model::Model cloth = testing::preset_with("stvk_orthotropic", kCloth);
  check_jacobian(cloth, {}, "plain");
  check_jacobian(cloth, {.transverse_free = true}, "transverse free");
}

TEST(Prediction, JacobianHoldsForEveryCorrection) {
  const std::vector<std::pair<std::string, double>> corrections = {
      {"offset", 0.7}, {"gain", 1.1},   {"drift", 0.003},
      {"delay", 0.4},  {"delay", -0.4}, {"clip_slip", -1.5}};
  for (const auto& [type, value] : corrections) {
    for (const char* component : {"x", ""}) {
      model::Model model = testing::preset_with("stvk_orthotropic", kCloth);
      testing::add_correction(model, type, component, value);
      if (type == "clip_slip") model.corrections.back().parameters[1].value = 70.0;
      check_jacobian(model, {}, type + " " + std::to_string(value) + " of " + component);
    }
  }
  model::Model all = testing::preset_with("stvk_orthotropic", kCloth);
  testing::add_correction(all, "delay", "", 0.35);
  testing::add_correction(all, "gain", "y", 0.9);
  testing::add_correction(all, "offset", "x", -0.4);
  testing::add_correction(all, "drift", "x", 0.002);
  check_jacobian(all, {}, "all together");
}

/// Stress that the model shows on channel x, frame by frame.
std::vector<double> shown_x(const model::Model& model) {
  Case c = case_of(model);
  const std::vector<double> all = c.evaluator.predicted(residuals_of(c.evaluator, c.parameters));
  std::vector<double> x;
  for (std::size_t r = 0; r < all.size(); ++r)
    if (c.evaluator.rows()[r].channel == 0) x.push_back(all[r]);
  return x;
}

TEST(Corrections, DoWhatTheyAreCalled) {
  const model::Model plain = testing::preset_with("stvk_orthotropic", kCloth);
  const auto with = [&](const std::string& type, double value) {
    model::Model model = plain;
    testing::add_correction(model, type, "x", value);
    return shown_x(model);
  };
  const std::vector<double> truth = shown_x(plain);
  const std::vector<double> offset = with("offset", 0.7);
  const std::vector<double> gain = with("gain", 1.1);
  const std::vector<double> drift = with("drift", 0.003);
  const double step_s = 0.06 / 25 / 0.002;
  ASSERT_GT(truth[20], 10.0);
  for (std::size_t f = 0; f < truth.size(); ++f) {
    EXPECT_NEAR(offset[f] - truth[f], 0.7, 1e-12);
    EXPECT_NEAR(gain[f], 1.1 * truth[f], 1e-12);
    EXPECT_NEAR(drift[f] - truth[f], 0.003 * step_s * static_cast<double>(f), 1e-9);
  }
  // a whole step late shows the reading before, a whole step early the one after
  const std::vector<double> late = with("delay", step_s);
  const std::vector<double> early = with("delay", -step_s);
  for (std::size_t f = 5; f < 45; ++f) {
    EXPECT_NEAR(late[f], truth[f - 1], 1e-9) << f;
    EXPECT_NEAR(early[f], truth[f + 1], 1e-9) << f;
  }
}

TEST(Corrections, AreOffAtTheirDefaults) {
  const model::Model plain = testing::preset_with("stvk_orthotropic", kCloth);
  const std::vector<double> truth = shown_x(plain);
  for (const auto& [type, off] : std::vector<std::pair<std::string, double>>{
           {"offset", 0.0}, {"gain", 1.0}, {"drift", 0.0}, {"delay", 0.0}, {"clip_slip", 0.0}}) {
    model::Model model = plain;
    testing::add_correction(model, type, "", off);
    const std::vector<double> shown = shown_x(model);
    for (std::size_t f = 0; f < truth.size(); ++f)
      EXPECT_NEAR(shown[f], truth[f], 1e-12) << type << " frame " << f;
  }
}

TEST(Corrections, OfOneChannelLeaveTheOthersAlone) {
  const model::Model plain = testing::preset_with("stvk_orthotropic", kCloth);
  model::Model model = plain;
  testing::add_correction(model, "offset", "y", 5.0);
  EXPECT_EQ(shown_x(model), shown_x(plain));
}

TEST(Prediction, UnknownCorrectionsAreRefused) {
  model::Model model = testing::preset_with("stvk_orthotropic", kCloth);
  testing::add_correction(model, "offset", "x", 0.0);
  model.corrections.back().type = "gremlin";
  EXPECT_FALSE(Evaluator::make(model, testing::data_of({testing::loop_capture({})}, 0.2)));
}

}  // namespace
}  // namespace tenter::estimation
