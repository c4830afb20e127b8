// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/next/clip_bench.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/model/catalogue.h"
#include "server/diagnosis/field/next/clip_way.h"
#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

using testing::compliant_cloth;
using testing::data_of;
using testing::sheets_of;
using testing::SheetTruth;

/// Along the weft, as `law` says, beside the cloth.
model::Model with(const std::string& law,
                  const std::vector<std::pair<const char*, double>>& values) {
  model::Model model = compliant_cloth();
  model.terms.push_back(new_term(model, "extra", "green_u", 0.0, law));
  for (const auto& [name, value] : values) set_parameter(model.terms.back().law, name, value);
  return model;
}

Experiment along_way(std::vector<ExperimentStep> steps) {
  return {"way", kWayOfClips, std::move(steps)};
}

/// A cloth with friction along the weft, pulled at one rate, and two models fitted to it.
class SheetAtOneRate : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const SheetTruth truth{.model = with("dahl", {{"a", 0.6}, {"b", 0.0}, {"tau", 0.004}}),
                           .frames = 12};
    data_ = data_of(sheets_of(truth, compliant_cloth()));
    model::Model rubs = with("dahl", {{"a", 0.3}, {"tau", 0.008}});
    set_parameter(rubs.terms.back().law, "b", 0.0, true);
    friction_ = fitted(rubs);
    viscous_ = fitted(with("maxwell", {{"k", 50.0}, {"relaxation_time", 5.0}}));
  }
  static void TearDownTestSuite() { data_ = {}; }

  static FieldFit fitted(const model::Model& start) {
    auto fit = fit_field(start, data_, {}, {.threads = 2});
    EXPECT_TRUE(fit) << (fit ? "" : fit.error().message);
    return fit ? std::move(*fit) : FieldFit();
  }
  static double apart(const Experiment& plan, const FieldFit& one, const FieldFit& other) {
    const auto first = foretell(plan, one, data_, 0, 2),
               second = foretell(plan, other, data_, 0, 2);
    EXPECT_TRUE(first && second);
    if (!first || !second) return std::nan("");
    const auto found = separation({*first, *second}, {&one.at, &other.at});
    EXPECT_TRUE(!found || found->telling_rows <= found->rows);
    return found ? std::sqrt(found->chi2 / found->rows) : std::nan("");
  }
  static std::optional<Design> design(const RigLimits& limits) {
    const std::vector<const FieldFit*> rivals = {&friction_, &viscous_};
    return design_next({&friction_.at, &viscous_.at}, clip_bench(rivals, data_, limits, 2), limits,
                       Question::of_rate);
  }

  static FieldData data_;
  static FieldFit friction_, viscous_;
};

FieldData SheetAtOneRate::data_;
FieldFit SheetAtOneRate::friction_;
FieldFit SheetAtOneRate::viscous_;

/// Between the middles of two bars.
double span(const estimation::Sequence& sequence, std::size_t frame) {
  std::vector<Eigen::Vector3d> middles;
  const auto& clips = sequence.boundaries.front().clips;
  for (std::size_t c = 0; c < clips.size(); ++c) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& place_m : clips[c].place_m)
      sum += sequence.frames[frame].clips[c].to_space(place_m);
    middles.emplace_back(sum / static_cast<double>(clips[c].place_m.size()));
  }
  return (middles.at(1) - middles.at(0)).norm();
}

TEST_F(SheetAtOneRate, TheWayOfTwoBarsIsTheStrainBetweenThem) {
  const estimation::Sequence& like = data_.sequences.front();
  const auto way = way_of(like);
  ASSERT_TRUE(way);
  double reach = 0.0;
  for (std::size_t f = 0; f < like.frames.size(); ++f)
    reach = std::max(reach, span(like, f) / span(like, 0) - 1.0);
  EXPECT_NEAR(way->reach, reach, 1e-12);
  EXPECT_GT(way->fastest_per_s, 0.0);

  const double half = 0.5 * reach;
  const Experiment plan = along_way({ramp_to(reach, 1e-3), hold_for(100.0), ramp_to(half, 1e-2)});
  const estimation::Sequence next = sequence_of(plan, like, *way);
  const std::size_t last = next.frames.size() - 1;
  EXPECT_NEAR(span(next, 0), span(like, 0), 1e-12);
  EXPECT_NEAR(span(next, last) / span(like, 0) - 1.0, half, 1e-12);
  double seconds = 0.0;
  for (const auto& frame : next.frames) seconds += frame.duration_s;
  EXPECT_NEAR(seconds, plan.duration_s(), 1e-9);
  EXPECT_EQ(next.frames.back().block, 2);
}

TEST(ClipWay, OfASheetThatNothingMovesThereIsNone) {
  const SheetTruth truth{.model = compliant_cloth(), .protocols = {"stretch_u"}, .frames = 4};
  estimation::Sequence still = data_of(sheets_of(truth, compliant_cloth())).sequences.front();
  for (auto& frame : still.frames) frame.clips = still.frames.front().clips;
  EXPECT_FALSE(way_of(still));
  still.frames.clear();
  EXPECT_FALSE(way_of(still));
}

TEST_F(SheetAtOneRate, RatesAndHoldsSeparateFrictionFromViscosity) {
  const double reach = way_of(data_.sequences.front())->reach;
  const double fast = way_of(data_.sequences.front())->fastest_per_s;
  const auto loop = [&](double rate) {
    return along_way({ramp_to(reach, rate), ramp_to(0.0, rate)});
  };
  EXPECT_NEAR(apart(loop(fast), friction_, friction_), 0.0, 1e-9);
  const double same = apart(loop(fast), friction_, viscous_);
  EXPECT_GT(apart(loop(0.1 * fast), friction_, viscous_), 1.5 * same);
  EXPECT_GT(apart(along_way({ramp_to(reach, fast), hold_for(300.0)}), friction_, viscous_), same);
}

TEST_F(SheetAtOneRate, ADesignKeepsTheLimitsOfTheRig) {
  const auto free = design({});
  ASSERT_TRUE(free);
  EXPECT_TRUE(free->plan.splits_rate());
  EXPECT_EQ(free->mounted_as, data_.sequences.front().name);
  EXPECT_GT(free->separation.of_noise(), 0.5);

  RigLimits tight;
  tight.largest_N = 0.6 * free->separation.largest_force;
  tight.largest_strain = 0.5 * free->plan.largest_strain();
  const auto within = design(tight);
  ASSERT_TRUE(within);
  EXPECT_LE(within->separation.largest_force, tight.largest_N);
  EXPECT_LE(within->plan.largest_strain(), tight.largest_strain * (1.0 + 1e-9));

  tight.largest_N = 1e-6 * free->separation.largest_force;
  EXPECT_FALSE(design(tight));
}

/// A fault of one capture has no part in what another would show.
TEST_F(SheetAtOneRate, WhatBelongsToACaptureSaysNothingOfTheNext) {
  model::Model model = friction_.at.model;
  const model::CorrectionRow& row = *model::find_correction("offset", model::Seen::sheets);
  const estimation::Sequence& sequence = data_.sequences.front();
  model.corrections.push_back(
      {"offset", "", sequence.name, "", "offset", model::default_parameters(row)});
  const FieldFit fit = fitted(model);
  const auto told = foretell(along_way({ramp_to(0.02, 1e-2)}), fit, data_, 0, 2);
  ASSERT_TRUE(told);
  const auto moving = moving_columns(fit.at);
  ASSERT_EQ(told->jacobian.cols(), static_cast<Eigen::Index>(moving.size()));
  const auto names = estimation::parameter_names(fit.at.model);
  for (std::size_t k = 0; k < moving.size(); ++k) {
    const bool is_of_capture = names[static_cast<std::size_t>(moving[k])].starts_with("offset");
    EXPECT_EQ(told->jacobian.col(static_cast<Eigen::Index>(k)).isZero(0.0), is_of_capture);
  }
}

}  // namespace
}  // namespace tenter::diagnosis
