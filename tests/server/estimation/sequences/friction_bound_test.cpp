// SPDX-License-Identifier: GPL-3.0-or-later
// Fitted friction never gains work: b tau <= 2 a.
#include <gtest/gtest.h>

#include <cmath>

#include "server/estimation/least_squares/dissipation.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/estimation/staged/parameter_ties.h"
#include "server/mechanics/friction/dahl_work.h"
#include "tests/server/estimation/sequences/picture_frame.h"

namespace tenter::estimation {
namespace {

using testing::measure;
using testing::picture_frame;
using testing::rubbing_cloth;
using testing::rubbing_values;

constexpr int kA = 6, kB = 7, kTau = 9;

TEST(FrictionBound, IsWhereTheDissipationBreaks) {
  for (const Eigen::Vector3d& at :
       {Eigen::Vector3d(0.5, 0.0, 0.01), Eigen::Vector3d(0.5, 40.0, 0.01),
        Eigen::Vector3d(0.01, 60.0, 0.02)}) {
    const double a = at[0], c = at[1], tau = at[2];
    const GrowthBound bound = growth_bound(a, c, tau);
    ASSERT_GT(bound.b, 0.0);
    const double below[] = {a, 0.999 * bound.b, c, tau}, above[] = {a, 1.001 * bound.b, c, tau};
    EXPECT_TRUE(mechanics::check_dissipation(below, 10.0).holds);
    EXPECT_FALSE(mechanics::check_dissipation(above, 10.0).holds);
    const double h = 1e-6;
    const auto slope = [&](double da, double dc, double dtau) {
      return (growth_bound(a + da, c + dc, tau + dtau).b -
              growth_bound(a - da, c - dc, tau - dtau).b) /
             (2.0 * (da + dc + dtau));
    };
    EXPECT_NEAR(bound.by_a, slope(h * a, 0.0, 0.0), 1e-6 * bound.b / a);
    EXPECT_NEAR(bound.by_tau, slope(0.0, 0.0, h * tau), 1e-6 * bound.b / tau);
    if (c > 0.0) {
      EXPECT_NEAR(bound.by_c, slope(0.0, h * c, 0.0), 1e-6 * bound.b / c);
    }
  }
}

TEST(FrictionBound, AFitEndsAtItOrAsIfItWereNotThere) {
  Eigen::VectorXd truth = rubbing_values();
  Sequence sequence = picture_frame(5);
  FitOptions options;
  options.friction = friction_places(rubbing_cloth(truth));
  ASSERT_EQ(options.friction.size(), 1U);
  EXPECT_EQ(options.friction[0].a, kA);

  // far from the bound, even from a start beyond it: the fit without
  measure(sequence, rubbing_cloth(truth), truth, 1.0, 5);
  Eigen::VectorXd start = truth;
  start[kB] = 80.0;
  start[kTau] = 0.02;
  model::Model model = rubbing_cloth(start);
  auto evaluator = SequenceEvaluator::make(model, {sequence}).value();
  const FitResult free = fit(evaluator, rubbing_cloth(truth), {});
  const FitResult bounded = fit(evaluator, model, options);
  ASSERT_TRUE(free.usable && bounded.usable) << bounded.message;
  for (const int p : {0, 1, 2, kA, kB, kTau})
    EXPECT_NEAR(bounded.parameters[p], free.parameters[p], 0.02 * free.std_error[p]) << p;

  // a material that gains work near rest: a, b and tau end where it just does not
  truth[kA] = 0.02;
  truth[kB] = 6.0;
  truth[kTau] = 0.04;
  measure(sequence, rubbing_cloth(truth), truth, 1.0, 6);
  model = rubbing_cloth(rubbing_values());
  auto gaining = SequenceEvaluator::make(model, {sequence}).value();
  const FitResult unbound = fit(gaining, model, {});
  ASSERT_TRUE(unbound.usable);
  ASSERT_GT(unbound.parameters[kB] * unbound.parameters[kTau], 2.5 * unbound.parameters[kA]);
  const FitResult held = fit(gaining, model, options);
  ASSERT_TRUE(held.usable) << held.message;
  EXPECT_NEAR(held.parameters[kB] * held.parameters[kTau], 2.0 * held.parameters[kA],
              1e-9 * held.parameters[kA]);
  EXPECT_EQ(held.states[kB], ParameterState::at_bound);
  EXPECT_EQ(held.states[kTau], ParameterState::free);
  EXPECT_GT(held.chi2, unbound.chi2);

  // the same through numbers that are shared
  ParameterTies ties = tie_terms(model, {}).value();
  const FitResult tied = fit_tied(gaining, ties, options);
  ASSERT_TRUE(tied.usable);
  EXPECT_NEAR(tied.chi2, held.chi2, 1e-6 * held.chi2);
  EXPECT_EQ(tied.states[kB], ParameterState::at_bound);
}

/// Comes to rest with no parameters whatever.
class Restless final : public ResidualFunction {
 public:
  explicit Restless(ResidualFunction& inner) : inner_(inner) {}
  int parameter_count() const override { return inner_.parameter_count(); }
  const std::vector<Row>& rows() const override { return inner_.rows(); }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd&, Eigen::VectorXd&,
                                               RowMatrix*) override {
    return mechanics::PathStatus::no_equilibrium;
  }

 private:
  ResidualFunction& inner_;
};

TEST(FrictionBound, AFitThatCannotStartSaysSo) {
  const model::Model model = rubbing_cloth(rubbing_values());
  Sequence sequence = picture_frame(5);
  measure(sequence, model, rubbing_values(), 1.0, 5);
  auto evaluator = SequenceEvaluator::make(model, {sequence}).value();
  Restless restless(evaluator);
  FitOptions options;
  options.friction = friction_places(model);
  ASSERT_EQ(options.friction.size(), 1U);
  const FitResult found = fit(restless, model, options);
  EXPECT_FALSE(found.usable);
  EXPECT_FALSE(found.message.empty());
}

}  // namespace
}  // namespace tenter::estimation
