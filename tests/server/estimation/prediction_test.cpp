// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/prediction.h"

#include <gtest/gtest.h>

#include <algorithm>
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
      {"offset", 0.7}, {"gain", 1.1},       {"drift", 0.003},        {"delay", 0.4},
      {"delay", -0.4}, {"clip_slip", -1.5}, {"cord_friction", 0.08}, {"saturation", 0.7}};
  for (const auto& [type, value] : corrections) {
    for (const char* component : {"x", ""}) {
      model::Model model = testing::preset_with("stvk_orthotropic", kCloth);
      testing::add_correction(model, type, component, value);
      if (type == "clip_slip") model.corrections.back().parameters[1].value = 70.0;
      if (type == "saturation") model.corrections.back().parameters[1].value = 3.0;
      check_jacobian(model, {}, type + " " + std::to_string(value) + " of " + component);
    }
  }
  model::Model all = testing::preset_with("stvk_orthotropic", kCloth);
  testing::add_correction(all, "delay", "", 0.35);
  testing::add_correction(all, "gain", "y", 0.9);
  testing::add_correction(all, "offset", "x", -0.4);
  testing::add_correction(all, "drift", "x", 0.002);
  testing::add_correction(all, "cord_friction", "x", 0.05);
  testing::add_correction(all, "saturation", "x", 0.9);
  all.corrections.back().parameters[1].value = 15.0;
  check_jacobian(all, {}, "all together");
  for (const char* type : {"camera_scale", "camera_length"})
    for (const char* component : {"y", ""}) {
      model::Model model = testing::preset_with("stvk_orthotropic", kCloth);
      testing::add_correction(model, type, component, 1.2);
      check_jacobian(model, {.transverse_free = true}, type);
    }
}

/// What the model shows on one channel, frame by frame.
std::vector<double> shown_on(int channel, const model::Model& model,
                             const testing::LoopPlan& plan) {
  Case c = case_of(model, plan);
  const std::vector<double> all = c.evaluator.predicted(residuals_of(c.evaluator, c.parameters));
  std::vector<double> shown;
  for (std::size_t r = 0; r < all.size(); ++r)
    if (c.evaluator.rows()[r].channel == channel) shown.push_back(all[r]);
  return shown;
}

std::vector<double> shown_x(const model::Model& model) {
  return shown_on(0, model, {});
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

TEST(Corrections, CordsAddWhileTheyArePulledAndCapsCut) {
  const model::Model plain = testing::preset_with("stvk_orthotropic", kCloth);
  model::Model cord = plain;
  testing::add_correction(cord, "cord_friction", "x", 0.1);
  model::Model capped = plain;
  testing::add_correction(capped, "saturation", "x", 1.0);
  capped.corrections.back().parameters[1].value = 12.0;
  const Case c = case_of(plain);
  const Curves& curves = c.data->curves.front();
  const std::vector<double> truth = shown_x(plain);
  const std::vector<double> on_cord = shown_x(cord);
  const std::vector<double> cut = shown_x(capped);
  ASSERT_EQ(truth.size(), curves.frame_count());
  int above = 0;
  int below = 0;
  for (std::size_t f = 1; f < truth.size(); ++f) {
    const double travel = curves.path.q[f][0] - curves.path.q[f - 1][0];
    if (curves.path.start[f] != mechanics::FrameStart::next || std::abs(travel) < 1e-6) continue;
    EXPECT_NEAR(on_cord[f], (travel > 0.0 ? 1.1 : 0.9) * truth[f], 1e-12) << f;
    EXPECT_NEAR(cut[f], std::min(truth[f], 12.0), 1e-12) << f;
    (truth[f] > 12.0 ? above : below) += 1;
  }
  EXPECT_GT(above, 5);
  EXPECT_GT(below, 5);
}

TEST(Corrections, CamerasScaleFreeStretchesOnly) {
  const model::Model plain = testing::preset_with("stvk_orthotropic", kCloth);
  const testing::LoopPlan plan{.transverse_free = true};
  const Case c = case_of(plain, plan);
  const auto& channels = c.data->curves.front().channels;
  ASSERT_EQ(channels.size(), 2U);
  ASSERT_TRUE(channels[0].is_stress && !channels[1].is_stress);
  const std::vector<double> stretch = shown_on(1, plain, plan);
  ASSERT_LT(*std::min_element(stretch.begin(), stretch.end()), 0.995);
  for (const char* type : {"camera_scale", "camera_length"}) {
    model::Model model = plain;
    testing::add_correction(model, type, "", 1.2);
    const double rest = type == std::string("camera_scale") ? 1.0 : 0.0;
    const std::vector<double> shown = shown_on(1, model, plan);
    for (std::size_t f = 0; f < stretch.size(); ++f)
      EXPECT_NEAR(shown[f], rest + 1.2 * (stretch[f] - rest), 1e-12);
    EXPECT_EQ(shown_on(0, model, plan), shown_on(0, plain, plan));
  }
}

TEST(Directions, StandStillBelowAHundredthAndTurnWhereTheExtremeIsLeft) {
  Curves curves;
  const double strains[] = {0.0, 0.0, 0.02, 0.05, 0.0503, 0.05, 0.0502, 0.03, 0.0, 0.01, 0.05};
  for (const double strain : strains) {
    curves.path.q.emplace_back(1.0 + strain, 1.0, 0.0);
    curves.path.start.push_back(mechanics::FrameStart::next);
  }
  curves.path.start.front() = mechanics::FrameStart::virgin;
  const std::vector<double> expected = {1, 1, 1, 1, 1, 1, 1, -1, -1, 1, 1};
  EXPECT_EQ(last_motions_of(curves, 0), expected);
  EXPECT_EQ(last_motions_of(curves, 1), std::vector<double>(expected.size(), 0.0));
  curves.path.start[8] = mechanics::FrameStart::rested;  // another run, from there on
  EXPECT_EQ(last_motions_of(curves, 0)[8], 1.0);
  curves.path.is_free[0] = true;
  EXPECT_EQ(last_motions_of(curves, 0), std::vector<double>(expected.size(), 0.0));
}

TEST(Corrections, AreOffAtTheirDefaults) {
  const model::Model plain = testing::preset_with("stvk_orthotropic", kCloth);
  const std::vector<double> truth = shown_x(plain);
  for (const auto& [type, off] :
       std::vector<std::pair<std::string, double>>{{"offset", 0.0},
                                                   {"gain", 1.0},
                                                   {"drift", 0.0},
                                                   {"delay", 0.0},
                                                   {"clip_slip", 0.0},
                                                   {"cord_friction", 0.0},
                                                   {"saturation", 0.0},
                                                   {"camera_scale", 1.0}}) {
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
