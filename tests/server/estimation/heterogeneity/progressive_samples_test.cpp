// SPDX-License-Identifier: GPL-3.0-or-later
// A sheet with a stiff patch hidden in the data: the patch is found; a sheet without gets no
// sample.
#include "server/estimation/heterogeneity/progressive_samples.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/estimation/sequences/folds/meaningful_rows.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/mechanics/equilibrium/equilibrium.h"
#include "tests/server/estimation/sequences/bars.h"

namespace tenter::estimation {
namespace {

constexpr double kSize_m = 0.1;
constexpr double kSigma_m = 2e-5;
const Eigen::Vector2d kPatch(0.07, 0.032);

model::Model sheet() {
  model::Model model = testing::cloth_model(testing::true_values());
  for (model::Term& term : model.terms)
    for (model::Parameter& p : term.law.parameters) p.fixed = term.strain.name.starts_with("bend");
  return model;
}

/// Three times as stiff around a place that no sample of the fit has.
model::Model with_patch() {
  MaterialSamples samples;
  samples.field.id = "truth";
  samples.field.width_m = 0.014;
  samples.terms = {"weft", "warp", "shear"};
  for (int j = -3; j <= 4; ++j)
    for (int i = -3; i <= 4; ++i) {
      samples.field.positions_m.push_back(kPatch.x() + 0.03 * i);
      samples.field.positions_m.push_back(kPatch.y() + 0.03 * j);
    }
  model::Model model = with_samples(sheet(), samples).value();
  for (model::Term& term : model.terms)
    if (term.support.sample == 3 * 8 + 3 + 1) term.law.parameters[0].value *= 3.0;
  return model;
}

/// Seen at every second node, with a force.
Sequence measured(const std::string& name, bool along_weft, const Eigen::Vector3d& moved,
                  const model::Model& truth, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Sequence sequence = testing::between_bars(name, along_weft, moved);
  sequence.frames.resize(3);
  sequence.points.clear();
  std::vector<int> seen;
  for (int j = 0; j < 9; ++j)
    for (int i = 0; i < 9; ++i)
      if ((i + j) % 2 == 0) {
        seen.push_back(9 * j + i);
        sequence.points.push_back({{kSize_m * i / 8.0, kSize_m * j / 8.0}, kSigma_m});
      }
  const auto bound = mechanics::MeshModel::make(truth, sequence.cloth).value();
  auto solver = mechanics::EquilibriumSolver::make(bound, sequence.boundaries[0]).value();
  const Eigen::VectorXd p = mechanics::term_parameters(truth);
  mechanics::State state = sequence.start;
  for (SequenceFrame& frame : sequence.frames) {
    state.clips = frame.clips;
    const auto result = solver.solve(p, sequence.loads, state, {});
    EXPECT_TRUE(result && result->is_good({})) << name;
    frame.points_m.resize(3, static_cast<Eigen::Index>(seen.size()));
    for (std::size_t k = 0; k < seen.size(); ++k)
      for (int c = 0; c < 3; ++c)
        frame.points_m(c, static_cast<Eigen::Index>(k)) =
            state.x[3 * seen[k] + c] + kSigma_m * normal(random);
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (const int node : sequence.boundaries[0].clips[1].nodes)
      pull += result->by_node.segment<3>(3 * node);
    frame.forces_N[0] =
        pull.dot(sequence.forces[0].direction) + sequence.forces[0].sigma_N * normal(random);
  }
  return sequence;
}

/// Height of wrinkles that the measured points of a held-out sequence have and no model shows.
SampledFit found_in(const model::Model& truth, unsigned seed, double wrinkles_m = 0.0,
                    bool looks_at_folds = false) {
  std::mt19937 random(seed);
  const std::vector<Sequence> seen = {measured("weft", true, {0.008, 0.0, 0.0}, truth, random),
                                      measured("warp", false, {0.0, 0.008, 0.0}, truth, random)};
  // pulls that leave the sheet flat: folds have more than one answer
  std::vector<Sequence> unseen = {measured("weft further", true, {0.011, 0.0, 0.0}, truth, random),
                                  measured("warp less", false, {0.0, 0.005, 0.0}, truth, random)};
  if (wrinkles_m > 0.0) {
    unseen.push_back(measured("wrinkled", true, {0.008, 0.0, 0.0}, truth, random));
    for (SequenceFrame& frame : unseen.back().frames)
      for (std::size_t k = 0; k < unseen.back().points.size(); ++k)
        frame.points_m(2, static_cast<Eigen::Index>(k)) +=
            wrinkles_m * std::cos(160.0 * unseen.back().points[k].material_m.y());
  }
  const auto make = [](const std::vector<Sequence>& sequences) -> MakeFor {
    return [&sequences](const model::Model& model) -> Expected<std::unique_ptr<ResidualFunction>> {
      auto evaluator = SequenceEvaluator::make(model, sequences);
      if (!evaluator) return tl::unexpected(evaluator.error());
      return std::make_unique<SequenceEvaluator>(std::move(*evaluator));
    };
  };
  MaterialSamples samples = even_samples(4, 4, kSize_m, kSize_m);
  samples.terms = {"weft", "warp", "shear"};
  model::Model start = sheet();
  for (int t = 0; t < 3; ++t)
    start.terms[static_cast<std::size_t>(t)].law.parameters[0].value *= 1.3;
  SampleOptions options;
  options.most = 2;
  options.tries = 1;
  options.fit.tolerance = 1e-5;
  if (looks_at_folds)
    options.meaningful = [](const ResidualFunction& function) {
      return meaningful_rows(static_cast<const SequenceEvaluator&>(function));
    };
  auto found = add_samples(start, samples, make(seen), make(unseen), options);
  EXPECT_TRUE(found) << (found ? "" : found.error().message);
  return *found;
}

TEST(MaterialSamples, AHiddenStiffPatchIsFound) {
  const SampledFit found = found_in(with_patch(), 3);
  ASSERT_FALSE(found.released.empty());
  const model::Field& field = found.model.fields.at(0);
  const auto place = [&](int k) {
    return Eigen::Vector2d(field.positions_m[static_cast<std::size_t>(2 * k)],
                           field.positions_m[static_cast<std::size_t>(2 * k + 1)]);
  };
  const int first = found.released[0];
  for (int k = 0; k < field.sample_count(); ++k)
    EXPECT_LE((place(first) - kPatch).norm(), (place(k) - kPatch).norm() + 1e-12) << k;
  EXPECT_LT(found.held_out, 0.5 * found.homogeneous_held_out);
  EXPECT_LT(found.training, 0.5 * found.homogeneous_training);
  EXPECT_EQ(parameters_of_sample(found.model, first).size(), 3u);
  for (const int parameter : parameters_of_sample(found.model, first)) {
    const auto names = parameter_names(found.model);
    const auto values = parameter_values(found.model);
    const std::string background = names[static_cast<std::size_t>(parameter)];
    if (background.starts_with("shear")) continue;  // pulls hardly show it
    const std::string other = background.substr(0, background.find('_')) + "_1.k";
    const auto at = std::find(names.begin(), names.end(), other) - names.begin();
    EXPECT_GT(values[parameter], 1.4 * values[at]) << background;
  }
}

TEST(MaterialSamples, AFoldedHeldOutFrameDoesNotDrownWhatTheOthersSay) {
  // its distances are a hundred times all others and no stiffness changes them
  EXPECT_TRUE(found_in(with_patch(), 3, 1e-2).released.empty());
  const SampledFit found = found_in(with_patch(), 3, 1e-2, true);
  ASSERT_FALSE(found.released.empty());
  EXPECT_EQ(found.steps[0].rows_left_out, 3 * 3 * 41);
  EXPECT_LT(found.held_out, 0.5 * found.homogeneous_held_out);
  // nothing is left out where nothing is folded
  EXPECT_EQ(found_in(with_patch(), 3, 0.0, true).steps[0].rows_left_out, 0);
}

TEST(MaterialSamples, AHomogeneousSheetGetsNone) {
  const SampledFit found = found_in(sheet(), 5);
  EXPECT_TRUE(found.released.empty());
  EXPECT_EQ(found.steps.size(), 1u);
  EXPECT_TRUE(found.model.fields.empty());
  ASSERT_EQ(found.fit.parameters.size(), 6);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(found.fit.parameters[i], testing::true_values()[i],
                5.0 * found.fit.std_error[i] + 1e-9);
  EXPECT_GT(found.fit.std_error[0], 1e-4);
}

TEST(MaterialSamples, EqualSamplesAreTheHomogeneousModel) {
  const model::Model base = sheet();
  const model::Model expanded = with_samples(base, even_samples(3, 2, kSize_m, kSize_m)).value();
  EXPECT_EQ(expanded.terms.size(), 36u);
  EXPECT_EQ(expanded.terms[7].id, "warp_2");
  const auto sequence = testing::between_bars("weft", true, {0.006, 0.0, 0.0});
  const auto a = mechanics::MeshModel::make(base, sequence.cloth).value();
  const auto b = mechanics::MeshModel::make(expanded, sequence.cloth).value();
  const Eigen::VectorXd x = 1.05 * sequence.start.x;
  Eigen::VectorXd ga, gb;
  double ea = 0.0, eb = 0.0;
  ASSERT_EQ(a.evaluate(x, mechanics::term_parameters(base), {&ea, &ga}),
            mechanics::AssemblyStatus::ok);
  ASSERT_EQ(b.evaluate(x, mechanics::term_parameters(expanded), {&eb, &gb}),
            mechanics::AssemblyStatus::ok);
  EXPECT_GT(ea, 1e-4);
  EXPECT_NEAR(ea, eb, 1e-12 * ea);
  EXPECT_LT((ga - gb).norm(), 1e-12 * ga.norm());
  EXPECT_FALSE(with_samples(expanded, even_samples(2, 2, 0.1, 0.1)));
  MaterialSamples wrong = even_samples(2, 2, 0.1, 0.1);
  wrong.terms = {"weft", "felt"};
  EXPECT_FALSE(with_samples(base, wrong));
}

}  // namespace
}  // namespace tenter::estimation
