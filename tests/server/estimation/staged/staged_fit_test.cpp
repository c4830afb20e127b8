// SPDX-License-Identifier: GPL-3.0-or-later
// The incremental fit of thesis 3.4.2 on a small rig: hidden curves, where refinement stops, what
// the records say, threads.
#include "server/estimation/staged/staged_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/document.h"
#include "common/model/presets.h"
#include "server/estimation/staged/tables/scenario_residual.h"
#include "server/estimation/staged/unseen.h"
#include "server/mechanics/law.h"
#include "tests/server/estimation/staged/small_rig.h"

namespace tenter::estimation {
namespace {

double stress_of(const model::Term& term, double strain) {
  const auto law = mechanics::make_law(term.law, 1).value();
  std::vector<double> values;
  for (const model::Parameter& p : term.law.parameters) values.push_back(p.value);
  mechanics::LawOutput out{};
  mechanics::LawInput in;
  in.strain = &strain;
  in.parameters = values.data();
  law->evaluate(in, out);
  return out.stress[0];
}

StagedOptions with_threads(int threads) {
  StagedOptions options;
  options.stage.threads = threads;
  return options;
}

const StageRecord& stage_of(const StagedResult& result, const std::string& name) {
  for (const StageRecord& stage : result.stages)
    if (stage.name == name) return stage;
  ADD_FAILURE() << "there is no stage " << name;
  return result.stages.front();
}

TEST(StagedFit, FindsTheCurvesThatWereHidden) {
  const model::Model truth = curved_cloth();
  RigOptions rig;
  rig.frames = 8;
  rig.force_sigma_N = 3e-4;
  const auto measured = measured_in_rig(truth, rig);
  auto start = model::preset("cloth_stvk_spline").value();
  StagedOptions options = with_threads(2);
  options.stage.weighting.rule = WeightingRule::by_noise;
  const auto fit = staged_fit(start, measured, options);
  ASSERT_TRUE(fit) << fit.error().message;
  ASSERT_EQ(fit->stages.size(), 12U);
  for (const StageRecord& stage : fit->stages) {
    EXPECT_TRUE(stage.done) << stage.name << ": " << stage.message;
    EXPECT_TRUE(stage.dropped.empty()) << stage.name;
    EXPECT_LE(stage.cost_after, stage.cost_before * (1.0 + 1e-3)) << stage.name;
  }
  EXPECT_GE(stage_of(*fit, "stretch_u").refinements.size(), 3U);
  // the noise floor is reached in the end
  const StageRecord& last = fit->stages.back();
  EXPECT_NEAR(last.cost_after / last.rows, 1.0, 0.15);
  // and the curves are the hidden ones where the data reached
  for (const std::size_t t : {0U, 1U}) {
    for (const double strain : {0.01, 0.03, 0.05}) {
      const double hidden = stress_of(truth.terms[t], strain);
      EXPECT_GT(hidden, 0.3);
      EXPECT_NEAR(stress_of(fit->model.terms[t], strain), hidden, 0.02 * hidden) << t << strain;
    }
  }
  const double shear = stress_of(truth.terms[2], 0.15);
  EXPECT_NEAR(stress_of(fit->model.terms[2], 0.15), shear, 0.03 * shear);
  for (const std::size_t t : {3U, 4U}) {
    const double bending = stress_of(truth.terms[t], 10.0);
    EXPECT_NEAR(stress_of(fit->model.terms[t], 10.0), bending, 0.05 * bending) << t;
  }
  EXPECT_TRUE(model::validate(fit->model));
}

TEST(StagedFit, StopsWhereAPointMoreBringsNothing) {
  model::Model truth = model::preset("cloth_stvk").value();
  const std::vector<double> hidden = {45.0, 80.0, 9.0, 2e-5, 6e-5, 3e-5};
  for (std::size_t k = 0; k < hidden.size(); ++k) parameters_of(truth)[k]->value = hidden[k];
  RigOptions rig;
  rig.frames = 20;
  const RoleSequence pulled = measured_in_rig(Role::stretch_u, truth, rig);
  auto model = truth;
  model.terms[0].law = model::preset("cloth_stvk_spline")->terms[0].law;
  StageOptions options;
  options.stop_at_noise = false;
  options.channels = Channels::all;  // many rows: one of few would gain 1 % by chance
  const auto record = fit_stage(model, {"stretch_u", {"weft"}, {}, {pulled}}, options);
  ASSERT_TRUE(record) << record.error().message;
  ASSERT_TRUE(record->done) << record->message;
  ASSERT_EQ(record->refinements.size(), 3U);  // one point; two and three in vain
  EXPECT_FALSE(record->refinements[1].kept || record->refinements[2].kept);
  ASSERT_EQ(model.terms[0].law.parameters.size(), 1U);
  EXPECT_NEAR(model.terms[0].law.parameters[0].value, 45.0, 0.5);
  EXPECT_TRUE(record->guessed);
  options.stop_at_noise = true;
  const auto at_noise = fit_stage(model, {"stretch_u", {"weft"}, {}, {pulled}}, options);
  ASSERT_TRUE(at_noise && at_noise->done);
  EXPECT_EQ(at_noise->refinements.size(), 1U);
}

TEST(StagedFit, TiedTermsShareOneCurveFittedToBothSequences) {
  const model::Model truth = curved_cloth();
  RigOptions rig;
  const auto measured = measured_in_rig(truth, rig);
  StagedOptions options = with_threads(1);
  options.coupled = options.repeat = false;
  options.ties = {{"weft", "warp"}, {"bend_weft", "bend_warp"}};
  const auto fit = staged_fit(model::preset("cloth_stvk_spline").value(), measured, options);
  ASSERT_TRUE(fit) << fit.error().message;
  ASSERT_EQ(fit->stages.size(), 5U);
  EXPECT_EQ(fit->stages[1].name, "stretch_u+stretch_v");
  const model::Law& weft = fit->model.terms[0].law;
  const model::Law& warp = fit->model.terms[1].law;
  ASSERT_EQ(weft.parameters.size(), warp.parameters.size());
  EXPECT_EQ(weft.range_hi, warp.range_hi);
  for (std::size_t k = 0; k < weft.parameters.size(); ++k)
    EXPECT_EQ(weft.parameters[k].value, warp.parameters[k].value);
  // a compromise: misfit is far above the noise, and between the two truths
  EXPECT_GT(fit->stages[1].cost_after, 10.0 * fit->stages[1].rows);
  const double stress = stress_of(fit->model.terms[0], 0.01);
  EXPECT_GT(stress, stress_of(truth.terms[0], 0.01));
  EXPECT_LT(stress, stress_of(truth.terms[1], 0.01));
}

TEST(StagedFit, IsTheSameToTheByteForAnyNumberOfThreads) {
  const model::Model truth = curved_cloth();
  RigOptions rig;
  rig.frames = 3;
  const auto measured = measured_in_rig(truth, rig);
  const auto start = model::preset("cloth_stvk_spline").value();
  const auto one = staged_fit(start, measured, with_threads(1));
  const auto two = staged_fit(start, measured, with_threads(2));
  ASSERT_TRUE(one && two);
  EXPECT_EQ(model::write_model(one->model), model::write_model(two->model));
  for (std::size_t s = 0; s < one->stages.size(); ++s)
    EXPECT_EQ(one->stages[s].cost_after, two->stages[s].cost_after);
}

TEST(StagedFit, GoneOnFromAnyOfItsStagesEndsInTheSameBytes) {
  RigOptions rig;
  rig.frames = 3;
  auto measured = measured_in_rig(curved_cloth(), rig);
  measured.resize(3);  // stretch and shear
  const auto start = model::preset("cloth_stvk_spline").value();
  StagedOptions options = with_threads(1);
  options.stage.most_points = 2;
  std::vector<StagedResult> parts;
  int frames = 0;
  options.stage.on_frame = [&](const StageFrame& frame) {
    EXPECT_EQ(frame.at.parameters.size(),
              static_cast<Eigen::Index>(parameter_names(frame.model).size()));
    ++frames;
  };
  options.on_stages_done = [&](const StagedResult& part) { parts.push_back(part); };
  const auto whole = staged_fit(start, measured, options);
  ASSERT_TRUE(whole) << whole.error().message;
  ASSERT_GE(parts.size(), 3U);
  EXPECT_GT(frames, 20);
  const int frames_of_all = frames;
  for (std::size_t k = 0; k < parts.size(); k += 2) {
    StagedOptions again = options;
    again.on_stages_done = {};
    again.resume = &parts[k];
    frames = 0;
    const auto resumed = staged_fit(start, measured, again);
    ASSERT_TRUE(resumed) << resumed.error().message;
    EXPECT_LT(frames, frames_of_all + (k == 0 ? 1 : 0));  // the first guess solves no frame
    EXPECT_EQ(model::write_model(resumed->model), model::write_model(whole->model)) << k;
    ASSERT_EQ(resumed->stages.size(), whole->stages.size());
    for (std::size_t s = 0; s < whole->stages.size(); ++s)
      EXPECT_EQ(resumed->stages[s].cost_after, whole->stages[s].cost_after);
  }
}

TEST(StagedFit, SaysWhatItLeftOut) {
  const model::Model truth = curved_cloth();
  RigOptions rig;
  rig.frames = 4;
  auto measured = measured_in_rig(truth, rig);
  measured.resize(1);  // stretch_u alone
  // a clip that the rest of the sheet cannot follow: its nodes are on one spot
  for (Eigen::Vector3d& place : measured[0].sequence.boundaries[0].clips[1].place_m)
    place.setZero();
  StagedOptions options = with_threads(1);
  const auto fit = staged_fit(model::preset("cloth_stvk_spline").value(), measured, options);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_FALSE(fit->stages[1].done);
  EXPECT_EQ(fit->stages[1].dropped.size(), 4U);
  EXPECT_FALSE(fit->stages[1].message.empty());
  EXPECT_EQ(stage_of(*fit, "shear").message, "there is no sequence");
}

TEST(StagedFit, HoldsDiagonalBendingThatTheStripsDoNotTell) {
  model::Model truth = model::preset("cloth_stvk").value();
  const double values[] = {45.0, 80.0, 9.0, 4e-5, 6e-5, 5e-5};
  for (std::size_t t = 0; t < 6; ++t) truth.terms[t].law.parameters[0].value = values[t];
  RigOptions rig;
  rig.frames = 3;
  rig.point_sigma_m = 0.1;  // what was seen is right, but worth nothing
  rig.noise = 0.0;
  auto measured = measured_in_rig(truth, rig);
  measured.erase(measured.begin(), measured.begin() + 3);  // strips alone
  StagedOptions options = with_threads(1);
  options.stage.first_guess = false;
  options.coupled = options.repeat = false;
  options.hold_unseen = true;
  const auto fit = staged_fit(truth, measured, options);
  ASSERT_TRUE(fit) << fit.error().message;
  const StageRecord& stage = stage_of(*fit, "bend_diagonal");
  EXPECT_TRUE(stage.held && stage.done) << stage.message;
  EXPECT_EQ(stage.message, "not seen by the data: held at what stands in for it");
  EXPECT_FALSE(stage_of(*fit, "bend_u").held);
  const auto k = [&](std::size_t term) { return fit->model.terms[term].law.parameters[0]; };
  EXPECT_TRUE(k(5).fixed);
  EXPECT_FALSE(k(5).std_error);
  EXPECT_FALSE(k(3).fixed || k(4).fixed);
  EXPECT_GT(k(5).value, 1e-6);
  EXPECT_NEAR(k(5).value, std::sqrt(k(3).value * k(4).value), 1e-6 * k(5).value);
  // and stays there in a later stage
  const auto again = staged_fit(fit->model, measured, options);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(stage_of(*again, "bend_diagonal").held);
  EXPECT_EQ(again->model.terms[5].law.parameters[0].value, k(5).value);
  // or where it is asked to be
  options.held_at = 3e-5;
  const auto asked = staged_fit(truth, measured, options);
  ASSERT_TRUE(asked) << asked.error().message;
  EXPECT_EQ(stage_of(*asked, "bend_diagonal").message,
            "not seen by the data: held at the value given for that");
  EXPECT_EQ(asked->model.terms[5].law.parameters[0].value, 3e-5);
}

TEST(Unseen, IsWhatTwoErrorsAreMoreThan) {
  model::Model model = model::preset("cloth_stvk").value();
  for (const std::size_t t : {3U, 4U}) model.terms[t].law.parameters[0].value = 0.1;
  const std::vector<std::string> diagonal = {"bend_diagonal"};
  FitResult result;
  result.parameters = Eigen::VectorXd::Constant(6, 1.0);
  result.std_error = Eigen::VectorXd::Constant(6, 0.4);
  result.states.assign(6, ParameterState::free);
  EXPECT_TRUE(is_seen(model, diagonal, result));
  result.std_error[4] = 9.0;  // of another term
  EXPECT_TRUE(is_seen(model, diagonal, result));
  result.std_error[5] = 0.6;
  EXPECT_FALSE(is_seen(model, diagonal, result));
  result.parameters[5] = 1e-3;  // surely small, beside the other two
  result.std_error[5] = 0.04;
  EXPECT_TRUE(is_seen(model, diagonal, result));
  result.std_error[5] = 0.0;
  result.states[5] = ParameterState::at_bound;
  EXPECT_FALSE(is_seen(model, diagonal, result));
  result.parameters[5] = 0.0;
  EXPECT_TRUE(is_seen(model, diagonal, result));
  result.states[5] = ParameterState::flat;
  EXPECT_FALSE(is_seen(model, diagonal, result));

  model::Model bent = model;
  bent.terms[3].law.parameters[0].value = 9e-6;
  bent.terms[4].law.parameters[0].value = 4e-6;
  const mechanics::Grid grid{3, 3, 0.1, 0.1};
  using mechanics::Diagonals;
  EXPECT_NEAR(stand_in(bent, mechanics::grid_mesh(grid, Diagonals::one).value()), 6e-6, 1e-18);
  EXPECT_EQ(stand_in(bent, mechanics::grid_mesh(grid, Diagonals::both).value()), 0.0);
  EXPECT_FALSE(are_held(bent, diagonal));
  hold_at(6e-6, diagonal, bent);
  EXPECT_TRUE(are_held(bent, diagonal));
  EXPECT_EQ(bent.terms[5].law.parameters[0].value, 6e-6);
  EXPECT_FALSE(bent.terms[4].law.parameters[0].fixed);
}

TEST(StagedFit, PutsBackAStageThatIsWorseForAllSequencesTogether) {
  // one specimen's weft is ten times as stiff as the other's, whose sequence counts for more: a
  // stage that sees the first alone ruins the second
  model::Model soft = model::preset("cloth_stvk").value();
  const std::vector<double> hidden = {45.0, 80.0, 9.0, 2e-5, 6e-5, 3e-5};
  for (std::size_t k = 0; k < hidden.size(); ++k) parameters_of(soft)[k]->value = hidden[k];
  model::Model stiff = soft;
  parameters_of(stiff)[0]->value = 450.0;
  RigOptions rig;
  rig.frames = 4;
  RoleSequence other = measured_in_rig(Role::stretch_u, soft, rig);
  other.role = Role::stretch_v;
  other.sequence.weight = 100.0;
  StagedOptions options = with_threads(1);
  options.repeat = options.coupled = options.stage.first_guess = false;
  for (const bool agree : {false, true}) {
    const model::Model& first = agree ? soft : stiff;
    const std::vector<RoleSequence> measured = {measured_in_rig(Role::stretch_u, first, rig),
                                                other};
    model::Model start = soft;
    parameters_of(start)[0]->value = 50.0;
    const auto fit = staged_fit(start, measured, options);
    ASSERT_TRUE(fit) << fit.error().message;
    const StageRecord& stage = stage_of(*fit, "stretch_u");
    EXPECT_LT(stage.cost_after, 0.1 * stage.cost_at_start);  // better by itself in both
    EXPECT_EQ(stage.done, agree) << stage.message;
    const double weft = fit->model.terms[0].law.parameters[0].value;
    if (agree) {
      EXPECT_NEAR(weft, 45.0, 0.5);
    } else {
      EXPECT_EQ(weft, 50.0);
      EXPECT_EQ(stage.message.rfind("put back: the cost over all sequences rose", 0), 0U);
    }
  }
}

TEST(StagedFit, PutsBackAGuessWithWhichNothingRests) {
  RigOptions rig;
  rig.frames = 6;
  rig.point_sigma_m = 7.5e-5;
  const auto measured = measured_in_rig(curved_cloth(), rig);
  const model::Model start = model::preset("cloth_stvk_friction").value();
  StagedOptions options = with_threads(2);
  options.repeat = options.coupled = false;
  const auto fit = staged_fit(start, measured, options);
  ASSERT_TRUE(fit) << fit.error().message;
  // noise strains back and forth where the sheet did not: a friction without measure
  const StageRecord& guess = stage_of(*fit, "first_guess");
  EXPECT_FALSE(guess.done);
  EXPECT_EQ(guess.message.rfind("put back: ", 0), 0U) << guess.message;
  for (const char* stage : {"stretch_u", "stretch_v"}) {
    EXPECT_TRUE(stage_of(*fit, stage).done) << stage_of(*fit, stage).message;
    EXPECT_TRUE(stage_of(*fit, stage).dropped.empty());
  }
}

TEST(StagedFit, SpringsTwoNodesApartAreFittedWithTheStretchThatTheyTakePartIn) {
  const auto springs = model::preset("cloth_springs").value();
  model::Model truth = springs;
  for (model::Parameter* p : parameters_of(truth)) p->value *= 3.0;
  const auto measured = measured_in_rig(truth, {});
  int along = 0;
  for (const auto& wave : plan_stages(springs, measured, {}))
    for (const StageTask& task : wave) {
      if (task.name.rfind("bend_u", 0) != 0) continue;
      EXPECT_EQ(task.along, terms_of(springs, Component::stretch_u));
      ASSERT_EQ(task.sequences.size(), 2U);
      EXPECT_EQ(task.sequences[1].role, Role::stretch_u);
      ++along;
    }
  EXPECT_EQ(along, 2);
  StagedOptions options = with_threads(2);
  options.repeat = options.coupled = false;
  const auto fit = staged_fit(springs, measured, options);
  ASSERT_TRUE(fit) << fit.error().message;
  for (const Role role : {Role::stretch_u, Role::stretch_v}) {
    const auto pulled = scenario_residual(fit->model, measured[role == Role::stretch_u ? 0 : 1]);
    const auto before = scenario_residual(springs, measured[role == Role::stretch_u ? 0 : 1]);
    ASSERT_TRUE(pulled && before);
    EXPECT_LT(pulled->force_N, 0.5 * before->force_N);
  }
}

TEST(StagedFit, StopsWhenAsked) {
  const auto measured = measured_in_rig(curved_cloth(), {});
  StagedOptions options = with_threads(1);
  int calls = 0;
  options.stage.on_progress = [&](const StageProgress& progress) {
    EXPECT_GE(progress.control_points, 1);
    return ++calls < 3;
  };
  const auto fit = staged_fit(model::preset("cloth_stvk_spline").value(), measured, options);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_TRUE(fit->stopped);
  EXPECT_EQ(calls, 3);
  EXPECT_LT(fit->stages.size(), 12U);
}

}  // namespace
}  // namespace tenter::estimation
