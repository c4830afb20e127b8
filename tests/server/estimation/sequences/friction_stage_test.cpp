// SPDX-License-Identifier: GPL-3.0-or-later
// Staged fits of models with friction: the first guess along the measured path, and a stage.
#include <gtest/gtest.h>

#include "server/estimation/staged/parameter_ties.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/estimation/staged/stage.h"
#include "server/estimation/staged/start/equation_gap.h"
#include "tests/server/estimation/sequences/picture_frame.h"

namespace tenter::estimation {
namespace {

using testing::measure;
using testing::picture_frame;
using testing::rubbing_cloth;
using testing::rubbing_values;

constexpr int kFitted[] = {0, 1, 2, 6, 7, 9};

/// Far from the truth in every fitted parameter.
model::Model neutral() {
  Eigen::VectorXd start = rubbing_values();
  start.head<3>().setConstant(100.0);
  start.tail<4>() << 1.0, 1.0, 0.0, 0.01;
  return rubbing_cloth(start);
}

TEST(FrictionStage, TheEquationGapWalksTheMeasuredPath) {
  Sequence sequence = picture_frame(7);
  const Eigen::VectorXd truth = rubbing_values();
  measure(sequence, rubbing_cloth(truth), truth, 0.0, 1);
  const model::Model model = neutral();
  const ParameterTies ties = tie_terms(model, {}).value();
  const auto gap = equation_gap(model, ties, {{&sequence, GapRows::all}}, {});
  ASSERT_TRUE(gap) << gap.error().message;
  EXPECT_EQ(gap->frames, static_cast<int>(sequence.frames.size()));  // none may be left out
  const Eigen::VectorXd p = ties.all(gap->q);
  for (const int k : kFitted) EXPECT_NEAR(p[k], truth[k], 0.02 * truth[k]) << k;
}

TEST(FrictionStage, AStageFindsElasticityAndFrictionFromNeutralValues) {
  Sequence sequence = picture_frame(7);
  const Eigen::VectorXd truth = rubbing_values();
  measure(sequence, rubbing_cloth(truth), truth, 1.0, 8);
  model::Model model = neutral();
  StageTask task;
  task.name = "all";
  for (const model::Term& term : model.terms) task.terms.push_back(term.id);
  task.sequences = {{Role::shear, sequence}};
  StageOptions options;
  options.channels = Channels::all;
  options.most_frames = 4;  // is not heeded: each frame is a step of the path
  const auto record = fit_stage(model, task, options);
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_TRUE(record->done) << record->message;
  EXPECT_TRUE(record->dropped.empty());
  EXPECT_EQ(record->rows, static_cast<int>(sequence.frames.size() * (3 * 49 + 3)));
  const Eigen::VectorXd found = mechanics::term_parameters(model);
  for (const int k : kFitted) EXPECT_NEAR(found[k], truth[k], 0.1 * truth[k]) << k;

  // and every frame rests along the path of what was found
  const auto rest = resting_frames(model, sequence, found, 1e-8);
  ASSERT_TRUE(rest);
  EXPECT_TRUE(rest->restless.empty());
}

}  // namespace
}  // namespace tenter::estimation
