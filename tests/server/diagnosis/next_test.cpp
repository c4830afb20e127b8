// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "server/diagnosis/next/curve_bench.h"
#include "tests/server/diagnosis/prepared_twin.h"

namespace tenter::diagnosis {
namespace {

/// One rate, no hold: friction hides, and viscosity does nearly as well.
class OneRate : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    twin::TwinCase twin;
    twin.effects = {"internal_friction:axes"};
    twin.size = 10.0;
    twin.suite = "single_rate";
    twin.seed = 31;
    Prepared prepared = testing::prepared_twin(twin);
    data_ = prepared.data;
    friction_ = with(prepared.baseline.model, "dahl", {{"b", 0.0, true}, {"tau", 0.008, false}});
    viscous_ = with(prepared.baseline.model, "maxwell",
                    {{"k", 50.0, false}, {"relaxation_time", 5.0, false}});
  }
  static void TearDownTestSuite() { data_.reset(); }

  struct Start {
    const char* name;
    double value;
    bool fixed;
  };
  static Reference with(model::Model model, const std::string& law,
                        const std::vector<Start>& starts) {
    for (const char* measure : {"green_u", "green_v"}) {
      model::Term term = new_term(model, std::string("extra_") + measure, measure, 0.0, law);
      for (const Start& start : starts)
        set_parameter(term.law, start.name, start.value, start.fixed);
      if (law == "dahl") set_parameter(term.law, "a", 1.0);
      model.terms.push_back(term);
    }
    auto fitted = make_reference(model, data_, {});
    EXPECT_TRUE(fitted) << (fitted ? "" : fitted.error().message);
    return std::move(fitted).value_or(Reference());
  }

  static std::optional<Separation> between(const Experiment& plan, const Reference& one,
                                           const Reference& other) {
    const auto first = foretell(plan, one, *data_, 0), second = foretell(plan, other, *data_, 0);
    if (!first || !second) return std::nullopt;
    return separation({*first, *second}, {&one, &other});
  }
  static std::optional<Design> design(const Reference& one, const Reference& other,
                                      const RigLimits& limits = {},
                                      Question question = Question::any) {
    const std::vector<const Reference*> rivals = {&one, &other};
    return design_next(rivals, curve_bench(rivals, *data_, limits), limits, question);
  }

  static double apart(const Experiment& plan) {
    const auto found = between(plan, friction_, viscous_);
    EXPECT_TRUE(found);
    return found ? found->of_noise() : 0.0;
  }

  static DataPointer data_;
  static Reference friction_, viscous_;
};

DataPointer OneRate::data_;
Reference OneRate::friction_;
Reference OneRate::viscous_;

Experiment pull_x(std::vector<ExperimentStep> steps) {
  return {"pull", 0, std::move(steps)};
}

TEST(Experiment, KnowsItsTimeItsReachAndItsWords) {
  const Experiment plan = pull_x({ramp_to(0.06, 1e-3), hold_for(300.0), ramp_to(-0.02, 1e-2)});
  EXPECT_NEAR(plan.duration_s(), 60.0 + 300.0 + 8.0, 1e-9);
  EXPECT_DOUBLE_EQ(plan.largest_strain(), 0.06);
  EXPECT_TRUE(plan.splits_rate());
  EXPECT_FALSE(pull_x({ramp_to(0.06, 1e-3), ramp_to(0.0, 2e-3)}).splits_rate());
  EXPECT_TRUE(pull_x({ramp_to(0.06, 1e-3), ramp_to(0.0, 4e-3)}).splits_rate());
  const std::vector<std::string> words = words_of(plan);
  ASSERT_EQ(words.size(), 3U);
  EXPECT_EQ(words[0], "x from 0 % to 6 % at 0.1 % a second");
  EXPECT_EQ(words[1], "hold at 6 % for 300 s");
  EXPECT_EQ(words[2], "x from 6 % to -2 % at 1 % a second");
}

TEST_F(OneRate, FramesOfAPlanFollowItsStrainAndItsClock) {
  const Experiment plan = pull_x({ramp_to(0.06, 1e-3), hold_for(100.0), ramp_to(0.0, 1e-2)});
  const estimation::Curves curves = curves_of(plan, data_->curves[0]);
  ASSERT_EQ(curves.blocks.size(), 3U);
  EXPECT_EQ(curves.blocks[0].first, 0);
  EXPECT_EQ(curves.blocks[2].last, static_cast<int>(curves.frame_count()));
  EXPECT_NEAR(curves.clock_s.back(), plan.duration_s(), 1e-9);
  EXPECT_NEAR(curves.path.q[static_cast<std::size_t>(curves.blocks[0].last - 1)][0], 1.06, 1e-12);
  EXPECT_NEAR(curves.path.q.back()[0], 1.0, 1e-12);
  EXPECT_EQ(curves.path.start.front(), mechanics::FrameStart::virgin);
  ASSERT_FALSE(curves.channels.empty());
  for (const auto& channel : curves.channels)
    EXPECT_EQ(channel.measured.size(), curves.frame_count());
}

TEST_F(OneRate, AModelIsNotApartFromItself) {
  const auto none = between(pull_x({ramp_to(0.06, 1e-3)}), friction_, friction_);
  ASSERT_TRUE(none);
  EXPECT_GT(none->largest_force, 1.0);
  EXPECT_NEAR(none->chi2, 0.0, 1e-12);
  EXPECT_FALSE(design(friction_, friction_));
}

// What the captures did says little; another rate and a hold say much.
TEST_F(OneRate, ARateAndAHoldSeparateFrictionFromViscosity) {
  const double same = apart(pull_x({ramp_to(0.06, 3e-3), ramp_to(0.0, 3e-3)}));
  const double rates = apart(pull_x({ramp_to(0.06, 3e-4), ramp_to(0.0, 3e-4)}));
  const double hold = apart(pull_x({ramp_to(0.06, 3e-3), hold_for(300.0)}));
  EXPECT_GT(rates, 2.0 * same);
  EXPECT_GT(hold, 2.0 * same);
}

TEST_F(OneRate, ADesignKeepsTheLimitsOfTheRig) {
  const auto free = design(friction_, viscous_);
  ASSERT_TRUE(free);
  EXPECT_GT(free->separation.of_noise(), 1.0);
  EXPECT_LE(free->plan.duration_s(), 3600.0);
  EXPECT_GT(free->considered, 4);

  RigLimits tight;
  tight.largest_strain = 0.03;
  tight.longest_s = 120.0;
  tight.largest_N_m = 0.7 * free->separation.largest_force;
  const auto within = design(friction_, viscous_, tight);
  ASSERT_TRUE(within);
  EXPECT_LE(within->plan.duration_s(), 120.0);
  EXPECT_LE(within->plan.largest_strain(), 0.03 * (1.0 + 1e-9));
  EXPECT_LE(within->separation.largest_force, tight.largest_N_m);
  EXPECT_LT(within->considered, free->considered);

  const auto of_rate = design(friction_, viscous_, {}, Question::of_rate);
  ASSERT_TRUE(of_rate);
  EXPECT_TRUE(of_rate->plan.splits_rate());

  RigLimits none;
  none.longest_s = 1e-3;
  EXPECT_FALSE(design(friction_, viscous_, none));
}

// The formula beside the dense problem that it solves.
TEST_F(OneRate, TheWrongModelGivesWayAsFarAsTheCapturesLetIt) {
  const Experiment plan = pull_x({ramp_to(0.06, 3e-4), ramp_to(0.0, 3e-4)});
  const auto found = between(plan, friction_, viscous_);
  ASSERT_TRUE(found);
  auto next = std::make_shared<estimation::DataSet>();
  next->curves = {curves_of(plan, data_->curves[0])};
  next->sigma = {data_->sigma[0]};
  next->left_out.emplace_back();
  for (const auto& channel : next->curves[0].channels)
    next->left_out[0].emplace_back(channel.measured.size(), false);
  double least = 1e300;
  for (const bool friction_moves : {true, false}) {
    const Reference& moved = friction_moves ? friction_ : viscous_;
    const Reference& still = friction_moves ? viscous_ : friction_;
    Eigen::VectorXd a, b;
    estimation::RowMatrix all;
    auto mover = estimation::Evaluator::make(moved.model, next);
    auto other = estimation::Evaluator::make(still.model, next);
    ASSERT_TRUE(mover && other);
    ASSERT_EQ(mover->evaluate(estimation::parameter_values(moved.model), a, &all),
              mechanics::PathStatus::ok);
    ASSERT_EQ(other->evaluate(estimation::parameter_values(still.model), b, nullptr),
              mechanics::PathStatus::ok);
    std::vector<Eigen::Index> free;
    for (std::size_t i = 0; i < moved.fit.states.size(); ++i)
      if (moved.fit.states[i] == estimation::ParameterState::free)
        free.push_back(static_cast<Eigen::Index>(i));
    // least squares of [J; J0] dp = [-(a - b); 0]
    const Eigen::MatrixXd j = all(Eigen::all, free);
    const Eigen::MatrixXd j0 = moved.fit.jacobian(Eigen::all, free);
    Eigen::MatrixXd stacked(j.rows() + j0.rows(), j.cols());
    stacked << j, j0;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(stacked.rows());
    right.head(j.rows()) = b - a;
    const Eigen::VectorXd dp = stacked.colPivHouseholderQr().solve(right);
    least = std::min(least, (stacked * dp - right).squaredNorm());
  }
  ASSERT_GT(least, 1.0);
  EXPECT_NEAR(found->chi2, least, 1e-5 * least);
}

}  // namespace
}  // namespace tenter::diagnosis
