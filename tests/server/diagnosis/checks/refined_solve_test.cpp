// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/checks/refined_solve.h"

#include <gtest/gtest.h>

#include "common/model/catalogue.h"
#include "server/diagnosis/prepare.h"
#include "server/estimation/thinning.h"
#include "tests/server/estimation/fixtures.h"

namespace tenter::diagnosis {
namespace {

/// The linear cloth with a further law along weft.
model::Model with_law(const std::string& law, const std::vector<double>& values) {
  model::Model model = testing::preset_with("stvk_orthotropic", {600.0, 800.0, 150.0, 100.0});
  model::Term term = model.terms.front();
  term.id = "more";
  term.law = model::Law();
  term.law.name = law;
  term.law.parameters = model::default_parameters(*model::find_law(law));
  for (std::size_t i = 0; i < values.size(); ++i) term.law.parameters[i].value = values[i];
  model.terms.push_back(term);
  return model;
}

struct Start {
  std::string law;
  std::vector<double> truth;
  std::vector<double> from;
};

struct Solved {
  Reference at;
  RefinedSolve refined;
};

/// Loops of the true model with noise, fitted from a start.
Solved solve(const Start& start, const estimation::FitOptions& options = {}) {
  estimation::DataSet set = *testing::data_of({testing::loop_capture({.runs = 3})}, 0.3);
  testing::measure_with(with_law(start.law, start.truth), 0.3, 5, set);
  const auto data = std::make_shared<const estimation::DataSet>(set);
  auto at = make_reference(with_law(start.law, start.from), data, options);
  EXPECT_TRUE(at) << start.law;
  if (!at) return {};
  EXPECT_TRUE(at->fit.converged) << start.law;
  return {*at, refined_solve(*at, data, set, 1, [] { return true; })};
}

TEST(RefinedSolve, FindsTheBetterBasin) {
  // a friction that the fit reads as an elastic spring; a set beyond all strains and a softening
  // that is over before the first frame, which have no gradient; an exponent out of all proportion
  for (const Start& start : {Start{"dahl", {4.0, 0.0, 0.0, 0.002}, {1.0, 1.0, 0.0, 10.0}},
                             Start{"plastic_set", {400.0, 0.02}, {10.0, 0.07}},
                             Start{"softening", {300.0, 0.01}, {10.0, 1e-4}},
                             Start{"exponential_fibre", {100.0, 400.0}, {100.0, 1e4}}}) {
    const auto [at, refined] = solve(start);
    EXPECT_GT(refined.chi2, 1.5 * refined.expected_chi2) << start.law;
    EXPECT_EQ(refined.effect, "wrong_basin") << start.law;
    ASSERT_TRUE(refined.better) << start.law;
    // down to the noise: no material is left to blame
    EXPECT_NEAR(refined.better->fit.chi2, refined.expected_chi2, 0.25 * refined.expected_chi2)
        << start.law;
    EXPECT_EQ(refined.better->fit.chi2, refined.restarted_chi2);
    EXPECT_GT(refined.continued_chi2, 1.5 * refined.expected_chi2) << start.law;
  }
}

TEST(RefinedSolve, FindsAnEarlyStop) {
  // a fit that takes the first step for the last
  estimation::FitOptions coarse;
  coarse.tolerance = 0.9;
  const auto [at, refined] =
      solve({"dahl", {4.0, 0.0, 0.0, 0.002}, {3.0, 0.1, 0.0, 0.003}}, coarse);
  EXPECT_EQ(refined.effect, "solver_tolerance");
  ASSERT_TRUE(refined.better);
  EXPECT_GT(refined.chi2, 5.0 * refined.expected_chi2);
  EXPECT_NEAR(refined.better->fit.chi2, refined.expected_chi2, 0.25 * refined.expected_chi2);
}

TEST(RefinedSolve, LeavesAGoodFitAlone) {
  for (const Start& start : {Start{"dahl", {4.0, 0.0, 0.0, 0.002}, {4.0, 0.1, 0.0, 0.003}},
                             Start{"maxwell", {300.0, 3.0}, {10.0, 1.0}},
                             Start{"plastic_set", {400.0, 0.02}, {10.0, 0.05}},
                             Start{"exponential_fibre", {100.0, 400.0}, {100.0, 1.0}}}) {
    const auto [at, refined] = solve(start);
    EXPECT_EQ(refined.effect, "") << start.law;
    EXPECT_FALSE(refined.better) << start.law;
    EXPECT_LE(refined.chi2 - refined.restarted_chi2, refined.threshold()) << start.law;
  }
}

TEST(RefinedSolve, SeesAPathThatIsTooCoarse) {
  const model::Model truth = with_law("dahl", {40.0, 0.0, 0.0, 0.004});
  estimation::DataSet set = *testing::data_of({testing::loop_capture({.frames = 60})}, 0.1);
  testing::measure_with(truth, 0.1, 5, set);
  for (const int frames : {3, 61}) {
    estimation::DataSet thin = set;
    thin.curves.front() = estimation::thin(set.curves.front(), frames, set.left_out.front());
    for (auto& channel : thin.left_out.front())
      channel.assign(thin.curves.front().frame_count(), false);
    const auto data = std::make_shared<const estimation::DataSet>(thin);
    const auto at = make_reference(truth, data, {});
    ASSERT_TRUE(at);
    const RefinedSolve refined = refined_solve(*at, data, set, 1, [] { return true; });
    EXPECT_EQ(refined.effect == "mesh_resolution", frames == 3) << frames;
    EXPECT_EQ(refined.path_chi2 > refined.threshold(), frames == 3) << frames;
  }
}

TEST(RefinedSolve, IsDeterministic) {
  const Start start = {"softening", {300.0, 0.01}, {10.0, 0.1}};
  const RefinedSolve one = solve(start).refined;
  const RefinedSolve two = solve(start).refined;
  ASSERT_TRUE(one.better);
  EXPECT_EQ(one.restarted_chi2, two.restarted_chi2);
  EXPECT_EQ(one.better->fit.parameters, two.better->fit.parameters);
}

/// Loops of a cloth with plastic set, asked of a model that has it, from a yield strain.
Expected<Diagnosis> diagnosis_from(double yield_strain) {
  Request request;
  capture::Capture capture = testing::loop_capture({.runs = 5});
  estimation::DataSet set = *testing::data_of({capture}, 0.3);
  testing::measure_with(with_law("plastic_set", {400.0, 0.02}), 0.3, 5, set);
  capture.channels[2].values = set.curves.front().channels[0].measured;
  capture.channels[3].values = set.curves.front().channels[1].measured;
  request.captures.emplace_back("loops", capture);
  request.model = with_law("plastic_set", {10.0, yield_strain});
  request.options.max_frames_per_block = 30;
  request.options.null_twins = 200;
  return diagnose(request, Control());
}

int numerical(const Diagnosis& d) {
  int count = 0;
  for (const Verdict& v : d.verdicts) count += v.kind == VerdictKind::numerical ? 1 : 0;
  return count;
}

TEST(Diagnose, BlamesTheSolverBeforeTheMaterial) {
  // the model has the effect; from a yield strain beyond all strains the fit does not see it
  const auto poor = diagnosis_from(0.5);
  ASSERT_TRUE(poor) << poor.error().message;
  ASSERT_EQ(numerical(*poor), 1);
  for (const Verdict& v : poor->verdicts) {
    EXPECT_NE(v.effect, "plastic_set") << v.words;
    if (v.kind != VerdictKind::numerical) continue;
    EXPECT_EQ(v.effect, "wrong_basin");
    EXPECT_GT(v.size, 0.005);
    EXPECT_FALSE(v.words.empty());
  }
  const auto good = diagnosis_from(0.05);
  ASSERT_TRUE(good) << good.error().message;
  EXPECT_EQ(numerical(*good), 0);
  EXPECT_NEAR(poor->baseline.fit.chi2, good->baseline.fit.chi2, 0.1 * good->baseline.fit.chi2);
}

}  // namespace
}  // namespace tenter::diagnosis
