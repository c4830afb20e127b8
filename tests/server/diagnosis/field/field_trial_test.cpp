// SPDX-License-Identifier: GPL-3.0-or-later
// Gates of one candidate on sheets: evidence is in the noise that is left, and accidents are asked
// too.
#include "server/diagnosis/field/field_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "tests/server/diagnosis/field/sheet_of.h"

namespace tenter::diagnosis {
namespace {

using testing::compliant_cloth;
using testing::data_of;
using testing::diagnosed;
using testing::first;
using testing::in_lines;
using testing::sheets_of;
using testing::SheetTruth;

TEST(FitField, BeginsWhereItWasMeasuredIfItsStartsLeadNowhere) {
  const SheetTruth truth{.model = compliant_cloth(), .protocols = {"stretch_u"}, .frames = 6};
  const FieldData data = data_of(sheets_of(truth, compliant_cloth()));
  model::Model model = compliant_cloth();
  for (const std::size_t t : {1, 2, 3, 4, 5}) model.terms[t].law.parameters[0].fixed = true;
  const auto plain = fit_field(model, data, {}, {});
  ASSERT_TRUE(plain) << plain.error().message;
  FieldStates nowhere = plain->states;
  for (auto& state : nowhere.front()) state.x.setConstant(std::nan(""));
  const auto again = fit_field(model, data, nowhere, {});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->at.fit.chi2, plain->at.fit.chi2);
}

/// Forces scatter eight times as far as is stated: what an offset of one takes off them is strong
/// evidence by what is stated, and none by what is left.
TEST(FieldTrial, ForcesThatScatterFurtherThanStatedAreNoEvidence) {
  const SheetTruth truth{
      .model = compliant_cloth(), .protocols = {"stretch_u"}, .frames = 12, .load_cells = 2.0};
  FieldData data = data_of(sheets_of(truth, compliant_cloth()));
  for (auto& force : data.sequences.front().forces) force.sigma_N /= 8.0;
  model::Model model = compliant_cloth();
  for (const std::size_t t : {1, 2, 3, 4, 5}) model.terms[t].law.parameters[0].fixed = true;
  const auto plain = fit_field(model, data, {}, {});
  ASSERT_TRUE(plain) << plain.error().message;
  Candidate offset;
  offset.effect = find_effect("load_cell_offset");
  offset.variant.corrections.push_back(
      new_sheet_correction(model, "offset", data.sequences.front().forces[1].name, ""));
  FieldTrial trial = refit_field(offset, *plain, data, {});
  ASSERT_TRUE(trial.trial.fit.usable);
  ASSERT_LT(f_test(plain->at.fit.chi2, trial.trial.fit.chi2, 1, trial.trial.parameters,
                   plain->at.fit.effective_rows),
            1e-3);
  judge_field(trial, *plain, data, {}, static_cast<double>(plain->rows.size()), {});
  EXPECT_GT(trial.trial.p_value, 1e-2);
  EXPECT_FALSE(trial.trial.objections.empty());
}

/// A third of a millimetre, in one capture of two: named, asked on what was left out, and no
/// hindrance to what a third capture is foretold.
TEST(FieldTrial, AStepIsAnAccident) {
  SheetTruth truth{.model = compliant_cloth(), .frames = 12};
  truth.otherwise = [](estimation::Sequence& sequence) {
    if (sequence.name != "stretch_u") return;
    const auto clip = static_cast<std::size_t>(sequence.forces[1].clip);
    for (std::size_t f = 7; f < sequence.frames.size(); ++f)
      sequence.frames[f].clips[clip].position_m.x() -= 3e-4;
  };
  SheetRequest request = sheets_of(truth, compliant_cloth());
  request.sequences.back().held_out = true;
  const SheetDiagnosis d = diagnosed(request);
  EXPECT_EQ(first(d).kind, VerdictKind::sensor) << in_lines(d);
  EXPECT_EQ(first(d).effect, "clip_slip") << in_lines(d);
  ASSERT_EQ(d.findings.size(), 1U) << in_lines(d);
  const Trial& trial = d.findings[0].trial;
  EXPECT_FALSE(trial.folds.empty());
  EXPECT_GT(trial.held_out_before - trial.held_out_after, trial.held_out_error);
  EXPECT_EQ(trial.model.corrections.back().parameters[1].value, 7.0);
  EXPECT_TRUE(d.held_out_after) << in_lines(d);
  EXPECT_FALSE(d.held_out_extended.rows.empty()) << in_lines(d);
}

/// Positions and forces are weighed one by one.
TEST(FieldTrial, WhatOneKindShowsIsNotTheFormOfWhatTheOtherShowed) {
  const auto objection = [](std::array<double, 2> first, std::array<double, 2> now,
                            std::array<double, 2> then) {
    return objection_by_kind({first[0] - now[0], first[1] - now[1]}, {now, {}}, {then, {}}, false);
  };
  // a bias of points that took much of the positions, then an effect that only forces show
  EXPECT_EQ(objection({75000.0, 2000.0}, {16000.0, 2000.0}, {15990.0, 200.0}), "");
  // what is left of forces is a small part of what was found by them
  EXPECT_NE(objection({11235.0, 2268.0}, {11234.0, 471.0}, {11247.0, 348.0}), "");
  // positions gain, and forces lose
  EXPECT_NE(objection({9574.0, 1752.0}, {9590.0, 261.0}, {9401.0, 306.0}), "");
}

Variant patches() {
  Variant variant;
  variant.parts_are_one = true;
  const model::Model cloth = compliant_cloth();
  for (int k = 0; k < 9; ++k)
    variant.append.push_back(
        new_term(cloth, "patch_" + std::to_string(k), "green_u", 0.0, "linear"));
  return variant;
}

/// The grid is wrong at the corners of clips, as a patch would be: more is asked of one.
TEST(FieldTrial, APatchIsToldFromTheErrorOfTheGrid) {
  const std::array<double, 2> taken = {1000.0, 0.0};
  const Misfit before{{5000.0, 400.0}, {}}, after{{4800.0, 400.0}, {}};
  EXPECT_EQ(objection_of_grid(taken, before, after, {}), "");
  EXPECT_NE(objection_of_grid(taken, before, after, patches()), "");
  const Misfit far_after{{4500.0, 400.0}, {}};
  EXPECT_EQ(objection_of_grid(taken, before, far_after, patches()), "");
}

/// What forces alone show lies in no part of the material.
TEST(FieldTrial, APatchThatNoPointShowsIsNone) {
  const SheetTruth truth{.model = compliant_cloth(), .protocols = {"stretch_u"}, .frames = 12};
  FieldData data = data_of(sheets_of(truth, compliant_cloth()));
  for (std::size_t f = 0; f < data.sequences.front().frames.size(); f += 2)
    data.sequences.front().frames[f].forces_N.array() += 0.1;
  model::Model model = compliant_cloth();
  for (const std::size_t t : {1, 2, 3, 4, 5}) model.terms[t].law.parameters[0].fixed = true;
  const auto plain = fit_field(model, data, {}, {});
  ASSERT_TRUE(plain) << plain.error().message;
  const auto objections = [&](bool points_gain) {
    FieldTrial trial;
    trial.trial.effect = find_effect("heterogeneity");
    trial.trial.variant = patches();
    trial.trial.model = plain->at.model;
    trial.trial.fit = plain->at.fit;
    const int points = 3 * static_cast<int>(data.sequences.front().points.size());
    for (std::size_t r = 0; r < plain->rows.size(); ++r)
      if (points_gain || plain->rows[r].channel >= points)
        trial.trial.fit.residuals[static_cast<Eigen::Index>(r)] *= 0.1;
    trial.trial.fit.chi2 = trial.trial.fit.residuals.squaredNorm();
    judge_field(trial, *plain, data, {}, static_cast<double>(plain->rows.size()), {});
    return std::ranges::count_if(trial.trial.objections, [](const std::string& objection) {
      return objection.starts_with("points, which it would move");
    });
  };
  EXPECT_EQ(objections(false), 1);
  EXPECT_EQ(objections(true), 0);
}

}  // namespace
}  // namespace tenter::diagnosis
