// SPDX-License-Identifier: GPL-3.0-or-later
// The first guess from forces at measured positions: exact without noise, near with it.
#include "server/estimation/staged/start/equation_gap.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/presets.h"
#include "server/estimation/staged/start/multi_start.h"
#include "tests/server/estimation/staged/small_rig.h"

namespace tenter::estimation {
namespace {

model::Model far_from(const model::Model& truth) {
  model::Model start = truth;
  int k = 0;
  for (model::Parameter* p : parameters_of(start)) p->value *= (k++ % 2 == 0) ? 3.0 : 0.25;
  return start;
}

std::vector<GapSequence> all_rows(const std::vector<RoleSequence>& measured) {
  std::vector<GapSequence> sequences;
  sequences.reserve(measured.size());
  for (const RoleSequence& s : measured) sequences.push_back({&s.sequence, GapRows::all});
  return sequences;
}

TEST(EquationGap, IsExactWithoutNoise) {
  const model::Model truth = curved_cloth();
  RigOptions rig;
  rig.noise = 0.0;
  rig.point_sigma_m = 1e-9;
  const auto measured = measured_in_rig(truth, rig);
  const ParameterTies ties = no_ties(far_from(truth));
  const auto gap = equation_gap(truth, ties, all_rows(measured), {});
  ASSERT_TRUE(gap) << gap.error().message;
  EXPECT_EQ(gap->rank, 18);
  EXPECT_EQ(gap->frames_left_out, 0);
  const Eigen::VectorXd hidden = parameter_values(truth);
  for (Eigen::Index k = 0; k < hidden.size(); ++k)
    EXPECT_NEAR(gap->q[k], hidden[k], 1e-5 * hidden[k])
        << parameter_names(truth)[static_cast<std::size_t>(k)];
}

TEST(EquationGap, ComesNearWithTheRigsNoise) {
  model::Model truth = model::preset("cloth_stvk").value();
  const std::vector<double> hidden = {45.0, 80.0, 9.0, 2e-5, 6e-5, 3e-5};
  for (std::size_t k = 0; k < hidden.size(); ++k) parameters_of(truth)[k]->value = hidden[k];
  RigOptions rig;
  rig.point_sigma_m = 7.5e-5;
  rig.force_sigma_N = 3e-3;
  const auto measured = measured_in_rig(truth, rig);
  const auto gap = equation_gap(truth, no_ties(far_from(truth)), all_rows(measured), {});
  ASSERT_TRUE(gap) << gap.error().message;
  for (std::size_t k = 0; k < 5; ++k)  // twist hardly shows in these sequences
    EXPECT_NEAR(gap->q[static_cast<Eigen::Index>(k)] / hidden[k], 1.0, 0.15) << k;
}

TEST(MultiStart, ReachesTheBestBasinMoreOftenWithAGuess) {
  model::Model truth = model::preset("cloth_stvk").value();
  const std::vector<double> hidden = {45.0, 80.0, 9.0, 2e-5, 6e-5, 3e-5};
  for (std::size_t k = 0; k < hidden.size(); ++k) parameters_of(truth)[k]->value = hidden[k];
  RigOptions rig;
  rig.nodes = 5;
  rig.frames = 3;
  std::vector<Sequence> one = {measured_in_rig(Role::evaluation, truth, rig).sequence};
  const ParameterTies ties = no_ties(truth);
  const auto starts = random_starts(ties, 6, 30.0, 3);
  ASSERT_EQ(starts.size(), 6U);
  EXPECT_NE(starts[0], starts[1]);
  EXPECT_LE((starts[2].array() / ties.values().array()).log().abs().maxCoeff(), std::log(30.0));
  MultiStartOptions options;
  options.fit.max_iterations = 20;
  options.guess = true;
  const auto one_thread = multi_start(truth, ties, one, starts, options);
  options.threads = 2;
  const auto two_threads = multi_start(truth, ties, one, starts, options);
  ASSERT_TRUE(one_thread && two_threads);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    EXPECT_EQ((*one_thread)[k].cost, (*two_threads)[k].cost);
    EXPECT_EQ((*one_thread)[k].start, (*two_threads)[k].start);
    EXPECT_GE((*one_thread)[k].cost, (*one_thread)[0].cost);
  }
  options.guess = false;
  const auto plain = multi_start(truth, ties, one, starts, options);
  ASSERT_TRUE(plain);
  EXPECT_GE(in_best_basin(*one_thread, 0.05), 5);
  EXPECT_GE(in_best_basin(*one_thread, 0.05), in_best_basin(*plain, 0.05));
  EXPECT_LE(one_thread->front().cost, plain->front().cost * (1.0 + 1e-3));
}

}  // namespace
}  // namespace tenter::estimation
