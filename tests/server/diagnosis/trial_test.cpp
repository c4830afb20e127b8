// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trials/trial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "server/diagnosis/verdicts/verdict_words.h"

namespace tenter::diagnosis {
namespace {

/// chi2 before that gives this F with chi2 after of one.
double before(double f, int added, double freedom) {
  return 1.0 + f * added / freedom;
}

TEST(FTest, HasTheTabulatedValues) {
  // upper critical values of F(added, freedom)
  EXPECT_NEAR(f_test(before(4.9646, 1, 10), 1.0, 1, 5, 15.0), 0.05, 1e-4);
  EXPECT_NEAR(f_test(before(3.3258, 5, 10), 1.0, 5, 7, 17.0), 0.05, 1e-4);
  EXPECT_NEAR(f_test(before(2.2899, 5, 100), 1.0, 5, 20, 120.0), 0.0513, 1e-3);
  EXPECT_NEAR(f_test(before(10.0443, 1, 10), 1.0, 1, 5, 15.0), 0.01, 1e-4);
  // two parameters: p = (1 + 2 F / freedom)^(-freedom / 2)
  EXPECT_NEAR(f_test(before(7.0, 2, 40), 1.0, 2, 10, 50.0), std::pow(1.35, -20.0), 1e-9);
}

TEST(FTest, OfNoGainOrTooFewRowsSaysNothing) {
  EXPECT_EQ(f_test(10.0, 10.0, 2, 5, 50.0), 1.0);
  EXPECT_EQ(f_test(10.0, 11.0, 2, 5, 50.0), 1.0);
  EXPECT_EQ(f_test(10.0, 5.0, 0, 5, 50.0), 1.0);
  EXPECT_EQ(f_test(10.0, 5.0, 2, 5, 5.5), 1.0);
  EXPECT_EQ(f_test(10.0, 0.0, 2, 5, 50.0), 0.0);
}

TEST(FTest, DoesNotSeeTheUnitOfChi2) {
  const double p = f_test(3.0, 2.0, 2, 6, 40.0);
  ASSERT_GT(p, 1e-6);
  ASSERT_LT(p, 0.5);
  EXPECT_NEAR(f_test(300.0, 200.0, 2, 6, 40.0), p, 1e-12);
}

TEST(ChiByBlock, AddsUpAndSkipsWhatNoFoldLeftOut) {
  const std::vector<estimation::Row> rows = {
      {0, 0, 0, 0}, {0, 0, 1, 0}, {0, 0, 2, 1}, {0, 0, 3, 1}};
  Eigen::VectorXd residuals(4);
  residuals << 1.0, 2.0, 3.0, std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(chi2_by_block(rows, residuals, 3), (std::vector<double>{5.0, 9.0, 0.0}));
}

TEST(Information, FallsWithChi2AndRisesWithWhatIsAdded) {
  const double plain = information(100.0, 5, 0, 80.0);
  EXPECT_LT(information(90.0, 5, 0, 80.0), plain);
  EXPECT_GT(information(100.0, 6, 0, 80.0), plain);
  EXPECT_GT(information(100.0, 5, 1, 80.0), plain);
}

TEST(ExplainedShare, IsOfWhatLiesAboveTheNoise) {
  EXPECT_NEAR(explained_share(200.0, 150.0, 100.0), 0.5, 1e-12);
  EXPECT_NEAR(explained_share(200.0, 100.0, 100.0), 1.0, 1e-12);
  EXPECT_NEAR(explained_share(200.0, 200.0, 100.0), 0.0, 1e-12);
}

TEST(WithinForm, IsWhatIsSmallBesideWhatWasFound) {
  EXPECT_TRUE(is_within_form(39.0, 1000.0, 0.2));
  EXPECT_FALSE(is_within_form(41.0, 1000.0, 0.2));
  EXPECT_FALSE(is_within_form(1.0, 0.0, 0.2));  // the first effect
}

TEST(Parameters, WhatTheDataDoNotMoveIsNotSpent) {
  estimation::FitResult fit;
  using estimation::ParameterState;
  fit.states = {ParameterState::free,  ParameterState::flat,     ParameterState::zero_gradient,
                ParameterState::fixed, ParameterState::at_bound, ParameterState::free};
  EXPECT_EQ(determined_count(fit), 2);
}

/// Friction that does not grow is no friction that grows.
TEST(Parameters, AnEffectHasWhatIsItsOwn) {
  Trial trial;
  trial.effect = find_effect("strain_dependent_friction");
  trial.model.terms.push_back(new_term({}, "friction_weft", "green_u", 0.0, "dahl"));
  trial.variant.append = trial.model.terms;
  const auto names = estimation::parameter_names(trial.model);
  const auto count = static_cast<Eigen::Index>(names.size());
  trial.fit.parameters = Eigen::VectorXd::Ones(count);
  trial.fit.std_error = Eigen::VectorXd::Constant(count, 0.01);
  trial.fit.correlation = Eigen::MatrixXd::Identity(count, count);
  trial.fit.states.assign(names.size(), estimation::ParameterState::free);
  check_parameters(trial);
  EXPECT_TRUE(trial.objections.empty()) << trial.objections.front();
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].ends_with(".b") || names[i].ends_with(".c"))
      trial.fit.states[i] = estimation::ParameterState::at_bound;
  check_parameters(trial);
  ASSERT_EQ(trial.objections.size(), 1U);
  EXPECT_EQ(trial.objections.front(), "what is its own (b, c) is not surely there");
}

/// A parameter more costs the logarithm of the rows that tell: forty of ten thousand do not tell a
/// rival apart that does as well.
TEST(EvidenceAgainst, CountsTheRowsThatTell) {
  Reference chosen, rival;
  chosen.fit.chi2 = rival.fit.chi2 = 1e4;
  chosen.fit.effective_rows = rival.fit.effective_rows = 1e4;
  for (int k = 0; k < 2; ++k)
    rival.model.terms.push_back(new_term({}, "more", "green_u", 0.0, "linear"));
  EXPECT_NEAR(evidence_against(rival, chosen), 2.0 * std::log(1e4), 1e-9);
  EXPECT_NEAR(evidence_against(rival, chosen, 40.0), 2.0 * std::log(40.0), 1e-9);
  rival.fit.chi2 = 1.01e4;
  EXPECT_NEAR(evidence_against(rival, chosen, 40.0), 1e4 * std::log(1.01) + 2.0 * std::log(40.0),
              1e-9);
}

/// A step of three in readings that scatter by one, here and there with a misread one beside it.
TEST(StepObjection, IsNoneWhereReadingsJump) {
  const std::vector<double> low = {0.4, -0.7, 0.9, -0.2, 9.0, 0.1};
  const std::vector<double> high = {3.3, 2.4, -9.0, 3.8, 2.9, 3.1};
  EXPECT_NEAR(jump_of(low, high), 2.8, 1e-12);
  EXPECT_EQ(step_objection({low, high, 3.0, 1.0}), "");
  EXPECT_EQ(step_objection({high, low, -3.0, 1.0}), "");
}

TEST(StepObjection, NamesWhatIsMissing) {
  const std::vector<double> low = {0.4, -0.7, 0.9, -0.2, 0.3, 0.1};
  const std::vector<double> high = {3.3, 2.4, 2.2, 3.8, 2.9, 3.1};
  const std::vector<double> ramp = {0.0, 0.1, 0.2, 0.3, 0.4, 0.5};
  EXPECT_NE(step_objection({low, high, -3.0, 1.0}), "");  // the other way
  EXPECT_NE(step_objection({low, high, 8.0, 1.0}), "");   // not half as far as is said
  EXPECT_NE(step_objection({low, high, 3.0, 1.5}), "");   // no further than readings scatter
  EXPECT_NE(step_objection({ramp, ramp, 3.0, 0.1}), "");
  EXPECT_NE(step_objection({low, {high[0], high[1]}, 3.0, 1.0}), "");
}

}  // namespace
}  // namespace tenter::diagnosis
