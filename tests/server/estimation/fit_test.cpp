// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "tests/server/estimation/fixtures.h"

namespace tenter::estimation {
namespace {

const std::vector<double> kCloth = {600.0, 800.0, 150.0, 100.0};

FitResult fit_of(const model::Model& start, const std::shared_ptr<const DataSet>& data,
                 const FitOptions& options = {}) {
  auto evaluator = Evaluator::make(start, data);
  EXPECT_TRUE(evaluator) << (evaluator ? "" : evaluator.error().message);
  return fit(*evaluator, start, options);
}

/// The cloth with its shear, which loops without shear cannot show, held.
model::Model start_cloth(const std::vector<double>& values = {300.0, 300.0, 10.0, 100.0}) {
  model::Model model = testing::preset_with("stvk_orthotropic", values);
  parameters_of(model)[3]->fixed = true;
  return model;
}

TEST(Fit, FindsWhatIsThereWithoutNoise) {
  for (const bool free : {false, true}) {
    auto data = testing::data_of({testing::loop_capture({.transverse_free = free})}, 0.2);
    testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.0, 1, *data);
    const FitResult found = fit_of(start_cloth(), data);
    ASSERT_TRUE(found.usable && found.converged) << found.message;
    EXPECT_LT(found.chi2, 1e-6);
    // a free direction shows only ratios of what resists it: with the force, k_u and the coupling
    if (free) continue;
    for (Eigen::Index i = 0; i < 3; ++i)
      EXPECT_NEAR(found.parameters[i], kCloth[static_cast<std::size_t>(i)], 1e-3) << i;
  }
}

/// A strip that narrows as it likes, and a model that does not mind.
TEST(Fit, AFreeDirectionThatNothingResistsIsRefused) {
  auto data = testing::data_of({testing::loop_capture({.transverse_free = true})}, 0.2);
  testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.2, 1, *data);
  model::Model weft = start_cloth();
  weft.terms.resize(1);
  const FitResult found = fit_of(weft, data);
  EXPECT_FALSE(found.usable);
  EXPECT_NE(found.message.find("must resist it"), std::string::npos) << found.message;
}

TEST(Fit, IntervalsHoldTheTruthAsOftenAsTheySay) {
  int inside = 0;
  int asked = 0;
  double spread = 0.0;
  double stated = 0.0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    auto data = testing::data_of({testing::loop_capture({.frames = 60})}, 0.4);
    testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.4, seed, *data);
    model::Model model = start_cloth();
    const FitResult found = fit_of(model, data);
    ASSERT_TRUE(found.usable && found.converged) << found.message;
    store(found, model);
    for (std::size_t i = 0; i < 3; ++i) {
      const model::Parameter& p = *parameters_of(model)[i];
      ASSERT_TRUE(p.interval_lo && p.interval_hi) << i;
      inside += *p.interval_lo <= kCloth[i] && kCloth[i] <= *p.interval_hi ? 1 : 0;
      ++asked;
      spread += std::pow(p.value - kCloth[i], 2.0) / 180.0;
      stated += *p.std_error * *p.std_error / 180.0;
    }
  }
  EXPECT_GE(inside, asked * 90 / 100);
  // and are no wider than honesty asks: residuals of white noise count nearly one by one
  EXPECT_GT(stated / spread, 0.7);
  EXPECT_LT(stated / spread, 2.0);
}

TEST(Fit, LeavesBendingWhereItWasAndSaysSo) {
  auto data = testing::data_of({testing::loop_capture({})}, 0.2);
  testing::measure_with(testing::preset_with("stvk_diagonal", {600.0, 800.0, 100.0}), 0.0, 1,
                        *data);
  const std::size_t points[] = {1, 5};
  std::size_t k = 0;
  for (const char* name : {"cloth_stvk", "cloth_stvk_spline"}) {
    model::Model model = model::preset(name).value();
    adapt_spline_ranges(model, data->curves);
    ASSERT_EQ(model.terms[3].strain.name, "bend_u");
    EXPECT_EQ(model.terms[3].law.range_lo, model.terms[3].law.range_hi);  // no curve reaches it
    const FitResult found = fit_of(model, data);
    ASSERT_TRUE(found.usable) << found.message;
    const std::size_t first = 3 * points[k];
    ASSERT_EQ(found.states.size(), 6 * points[k]);
    for (std::size_t i = first; i < found.states.size(); ++i) {
      EXPECT_EQ(found.states[i], ParameterState::zero_gradient) << name << " " << i;
      EXPECT_EQ(found.parameters[static_cast<Eigen::Index>(i)], 1e-5);
    }
    EXPECT_GT(found.parameters[0], 400.0);  // and the stretch was found beside it
    ++k;
  }
}

TEST(Fit, FreeDirectionsTellTheCoupling) {
  auto data = testing::data_of({testing::loop_capture({.transverse_free = true}),
                                testing::loop_capture({.peak = 0.04, .group = "biaxial"})},
                               0.2);
  testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.2, 5, *data);
  const FitResult found = fit_of(start_cloth(), data);
  ASSERT_TRUE(found.converged) << found.message;
  for (Eigen::Index i = 0; i < 3; ++i)
    EXPECT_NEAR(found.parameters[i], kCloth[static_cast<std::size_t>(i)],
                4.0 * found.std_error[i] + 1e-6)
        << i;
  EXPECT_LT(found.std_error[2], 0.05 * kCloth[2]);
}

TEST(Fit, FindsFrictionAndItsScale) {
  model::Model cloth = testing::preset_with("stvk_orthotropic", kCloth);
  parameters_of(cloth)[3]->fixed = true;
  model::Term friction = cloth.terms.front();
  friction.id = "friction";
  friction.strain.name = "green_u";
  friction.law.name = "dahl";
  friction.law.parameters = model::default_parameters(*model::find_law("dahl"));
  for (model::Parameter& p : friction.law.parameters) {
    if (p.name == "a") p.value = 2.0;
    if (p.name == "tau") p.value = 0.004;
    if (p.name == "b" || p.name == "c") p.fixed = true;
  }
  cloth.terms.push_back(friction);
  auto data = testing::data_of({testing::loop_capture({.frames = 60})}, 0.05);
  testing::measure_with(cloth, 0.05, 3, *data);
  model::Model start = cloth;
  for (model::Parameter& p : start.terms.back().law.parameters)
    if (!p.fixed) p.value *= 2.0;
  const FitResult found = fit_of(start, data);
  ASSERT_TRUE(found.converged) << found.message;
  const auto names = parameter_names(start);
  int checked = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (names[i] != "friction.a" && names[i] != "friction.tau") continue;
    const double truth = names[i] == "friction.a" ? 2.0 : 0.004;
    EXPECT_NEAR(found.parameters[k], truth, 0.05 * truth) << names[i];
    EXPECT_EQ(found.states[i], ParameterState::free);
    ++checked;
  }
  EXPECT_EQ(checked, 2);
}

TEST(Fit, BoundsAreRespectedAndSaid) {
  auto data = testing::data_of({testing::loop_capture({})}, 0.2);
  testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.2, 2, *data);
  model::Model model = start_cloth();
  parameters_of(model)[0]->upper = 500.0;
  const FitResult found = fit_of(model, data);
  ASSERT_TRUE(found.usable);
  EXPECT_NEAR(found.parameters[0], 500.0, 1e-3);
  EXPECT_LE(found.parameters[0], 500.0 + 1e-9);
  EXPECT_EQ(found.states[0], ParameterState::at_bound);
  EXPECT_EQ(found.std_error[0], 0.0);
  EXPECT_EQ(found.states[3], ParameterState::fixed);
  EXPECT_EQ(found.parameters[3], 100.0);
  store(found, model);
  EXPECT_FALSE(parameters_of(model)[0]->interval_lo);
}

TEST(Fit, SaysWhatTheDataDoNotShow) {
  auto data = testing::data_of({testing::loop_capture({})}, 0.2);
  testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.2, 2, *data);
  model::Model model = start_cloth();
  parameters_of(model)[3]->fixed = false;  // shear, which nothing moves
  EXPECT_EQ(fit_of(model, data).states[3], ParameterState::zero_gradient);
  // two terms that are one: neither is determined
  model = start_cloth();
  model.terms.push_back(model.terms.front());
  model.terms.back().id = "twin";
  const FitResult doubled = fit_of(model, data);
  ASSERT_TRUE(doubled.usable);
  int flat = 0;
  for (const ParameterState state : doubled.states) flat += state == ParameterState::flat ? 1 : 0;
  EXPECT_GE(flat, 2);
}

TEST(Fit, WeightsOfZeroAreNotSeen) {
  auto data = testing::data_of({testing::loop_capture({.runs = 2})}, 0.2);
  testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.0, 2, *data);
  const std::vector<Row> rows = data->rows();
  FitOptions options;
  options.weights = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows[r].frame >= 51) {
      options.weights[static_cast<Eigen::Index>(r)] = 0.0;
      data->curves[0]
          .channels[static_cast<std::size_t>(rows[r].channel)]
          .measured[static_cast<std::size_t>(rows[r].frame)] += 50.0;
    }
  const FitResult found = fit_of(start_cloth(), data, options);
  EXPECT_LT(found.chi2, 1e-6);
  EXPECT_NEAR(found.parameters[0], kCloth[0], 1e-3);
  EXPECT_GT(found.residuals.norm(), 1000.0);
}

TEST(Fit, CanBeStopped) {
  auto data = testing::data_of({testing::loop_capture({})}, 0.2);
  testing::measure_with(testing::preset_with("stvk_orthotropic", kCloth), 0.2, 2, *data);
  FitOptions options;
  options.on_iteration = [](int, double) { return false; };
  const FitResult found = fit_of(start_cloth(), data, options);
  EXPECT_TRUE(found.stopped);
  EXPECT_FALSE(found.converged);
}

/// Residuals of first-order autoregression, unit variance.
Eigen::VectorXd correlated(std::size_t count, double carry, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXd x(static_cast<Eigen::Index>(count));
  double last = normal(engine);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    x[i] = last;
    last = carry * last + std::sqrt(1.0 - carry * carry) * normal(engine);
  }
  return x;
}

double counted(double carry) {
  const auto data = testing::data_of({testing::loop_capture({.runs = 4, .frames = 100})}, 0.2);
  const std::vector<Row> rows = data->rows();
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(rows.size()));
  double share = 0.0;
  for (unsigned seed = 1; seed <= 10; ++seed)
    share += effective_rows(rows, correlated(rows.size(), carry, seed), ones) /
             static_cast<double>(rows.size()) / 10.0;
  return share;
}

TEST(EffectiveRows, CountWhiteNoiseOneByOneAndCorrelatedNoiseLess) {
  EXPECT_GT(counted(0.0), 0.7);
  EXPECT_LE(counted(0.0), 1.0);
  // (1 - carry) / (1 + carry) of the rows are independent
  for (const double carry : {0.5, 0.8}) {
    const double expected = (1.0 - carry) / (1.0 + carry);
    EXPECT_GT(counted(carry), 0.7 * expected) << carry;
    EXPECT_LT(counted(carry), 1.6 * expected) << carry;
  }
}

TEST(EffectiveRows, AConstantResidualIsOnePieceOfEvidenceABlock) {
  const auto data = testing::data_of({testing::loop_capture({.runs = 2, .frames = 100})}, 0.2);
  const std::vector<Row> rows = data->rows();
  const auto n = static_cast<Eigen::Index>(rows.size());
  const double rows_left = effective_rows(rows, Eigen::VectorXd::Ones(n), Eigen::VectorXd::Ones(n));
  // four blocks of two channels
  EXPECT_GE(rows_left, 8.0);
  EXPECT_LE(rows_left, 16.0);
}

}  // namespace
}  // namespace tenter::estimation
