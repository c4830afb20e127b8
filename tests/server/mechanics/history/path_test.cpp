// SPDX-License-Identifier: GPL-3.0-or-later
// Equilibrium along a path: frames that remember, and how the whole path answers to parameters.
#include <gtest/gtest.h>

#include "server/mechanics/equilibrium/sensitivity.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/history/friction.h"
#include "tests/server/mechanics/sparse/count_allocations.h"

namespace tenter::mechanics::testing {
namespace {

using tenter::testing::Comparison;

EquilibriumOptions to_rounding() {
  EquilibriumOptions options;
  options.tolerance_N = 0.0;
  return options;
}

double pull_N(const HeldSheet& sheet, const EquilibriumResult& result, int axis) {
  double sum = 0.0;
  for (const int n : sheet.upper) sum += result.by_node[3 * static_cast<Eigen::Index>(n) + axis];
  return sum;
}

TEST(PathOfASheet, TheSameStrainCostsLessOnTheWayBack) {
  const HeldSheet sheet(7, rubbing_cloth());
  std::vector<HeldSheet::Frame> frames;
  for (const double shear : {0.0, 0.03, 0.06, 0.09, 0.06, 0.03, 0.06, 0.09, 0.06, 0.03, 0.06, 0.09})
    frames.push_back({0.05, shear});
  const Walk path = walk(sheet, frames, sheet.parameters, to_rounding());
  const auto shear_N = [&](std::size_t k) { return pull_N(sheet, path.results[k], 0); };
  EXPECT_GT(shear_N(2), 1.3 * shear_N(4));
  // the way up again is another one, and the loop closes on itself cycle by cycle
  EXPECT_GT(shear_N(6), 1.1 * shear_N(4));
  EXPECT_LT(shear_N(6), 0.95 * shear_N(2));
  const double open_N = std::abs(shear_N(7) - shear_N(3));
  EXPECT_LT(open_N, 0.05 * shear_N(3));
  EXPECT_LT(std::abs(shear_N(11) - shear_N(7)), 0.3 * open_N);
}

TEST(PathOfASheet, AFrameThatMovesNothingChangesNothing) {
  const HeldSheet sheet(7, rubbing_cloth());
  auto frames = partial_reversals();
  frames.resize(5);
  frames.push_back(frames.back());
  const Walk path = walk(sheet, frames, sheet.parameters, to_rounding());
  const double scale = path.results[4].by_node.lpNorm<Eigen::Infinity>();
  ASSERT_GT(scale, 1e-2);
  EXPECT_LT((path.states[5].x - path.states[4].x).lpNorm<Eigen::Infinity>(), 1e-12);
  EXPECT_LT((path.results[5].by_node - path.results[4].by_node).lpNorm<Eigen::Infinity>(),
            1e-9 * scale);
}

TEST(PathOfASheet, SensitivitiesOfStatesAndForcesAlongTheWholePath) {
  const HeldSheet sheet(7, rubbing_cloth());
  const auto frames = partial_reversals();
  auto solver = EquilibriumSolver::make(sheet.model, sheet.boundary).value();
  History history = sheet.model.never_strained();
  Eigen::MatrixXd by_parameter =
      Eigen::MatrixXd::Zero(sheet.model.history_count(), sheet.parameters.size());
  State state = sheet.start;
  std::vector<Sensitivity> changes;
  std::vector<Eigen::MatrixXd> ends;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    sheet.hold(frames[k], state);
    EquilibriumOptions options = to_rounding();
    options.start_is_near = k > 0;
    const auto result = solver.solve(sheet.parameters, {}, state, options, &history);
    ASSERT_TRUE(result && result->is_good(options));
    auto change = sensitivity_along_path(solver, sheet.parameters, state, nullptr, by_parameter);
    ASSERT_TRUE(change) << change.error().message;
    changes.push_back(std::move(*change));
    ends.push_back(by_parameter);
    ASSERT_EQ(sheet.model.end_of_step(state.x, sheet.parameters, history, history.state),
              AssemblyStatus::ok);
  }
  for (const std::size_t k : {std::size_t{1}, std::size_t{4}, frames.size() - 1}) {
    Comparison x("x, frame " + std::to_string(k)), forces("forces, frame " + std::to_string(k)),
        past("history, frame " + std::to_string(k));
    for (Eigen::Index p = 0; p < sheet.parameters.size(); ++p) {
      const double value = sheet.parameters[p];
      const double scale = value;
      const double h = 2e-4 * scale;
      const auto moved = [&](double to) {
        Eigen::VectorXd parameters = sheet.parameters;
        parameters[p] = to;
        const std::vector<HeldSheet::Frame> some(frames.begin(),
                                                 frames.begin() + static_cast<long>(k) + 1);
        const Walk path = walk(sheet, some, parameters, to_rounding());
        Eigen::VectorXd all(2 * state.x.size() + history.state.size());
        all << path.states[k].x, path.results[k].by_node, path.histories[k];
        return all;
      };
      const Eigen::VectorXd slope = (moved(value + h) - moved(value - h)) / (2.0 * h);
      const Eigen::Index n = state.x.size();
      for (Eigen::Index i = 0; i < n; ++i) {
        x.add(changes[k].x(i, p) * scale, slope[i] * scale);
        // forces on free nodes are what the solver left of them
        const bool is_held = std::find(sheet.boundary.held.begin(), sheet.boundary.held.end(),
                                       static_cast<int>(i / 3)) != sheet.boundary.held.end();
        if (is_held) forces.add(changes[k].gradient(i, p) * scale, slope[n + i] * scale);
      }
      for (Eigen::Index i = 0; i < history.state.size(); ++i)
        past.add(ends[k](i, p) * scale, slope[2 * n + i] * scale);
    }
    x.judge(1e-5, 1e-6);
    forces.judge(1e-5, 1e-3);
    past.judge(1e-5, 1e-2);
  }

  // by some parameters alone: those columns
  const std::vector<Eigen::Index> only = {2, 14};
  Eigen::MatrixXd some = Eigen::MatrixXd::Zero(sheet.model.history_count(), 2);
  History again = sheet.model.never_strained();
  state = sheet.start;
  for (std::size_t k = 0; k < 5; ++k) {
    sheet.hold(frames[k], state);
    EquilibriumOptions options = to_rounding();
    options.start_is_near = k > 0;
    ASSERT_TRUE(solver.solve(sheet.parameters, {}, state, options, &again));
    const auto change = sensitivity_along_path(solver, sheet.parameters, state, &only, some);
    ASSERT_TRUE(change);
    ASSERT_EQ(sheet.model.end_of_step(state.x, sheet.parameters, again, again.state),
              AssemblyStatus::ok);
  }
  for (int c = 0; c < 2; ++c)
    EXPECT_LT((some.col(c) - ends[4].col(only[static_cast<std::size_t>(c)])).norm(),
              1e-9 * some.col(c).norm());
}

TEST(PathOfASheet, FramesAfterTheFirstTakeAsMuchFromTheHeap) {
  const HeldSheet sheet(7, rubbing_cloth());
  const auto frames = partial_reversals();
  auto solver = EquilibriumSolver::make(sheet.model, sheet.boundary).value();
  History history = sheet.model.never_strained();
  State state = sheet.start;
  std::vector<long> taken;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    sheet.hold(frames[k], state);
    EquilibriumOptions options;
    options.start_is_near = k > 0;
    const long before = test::allocations();
    const auto result = solver.solve(sheet.parameters, {}, state, options, &history);
    taken.push_back(test::allocations() - before);
    ASSERT_TRUE(result && result->is_good(options));
    const long solved = test::allocations();
    ASSERT_EQ(sheet.model.end_of_step(state.x, sheet.parameters, history, history.state),
              AssemblyStatus::ok);
    EXPECT_EQ(test::allocations(), solved);
  }
  EXPECT_GT(taken[0], taken[1]) << "the counter counts";
  for (std::size_t k = 2; k < taken.size(); ++k) EXPECT_LE(taken[k], 12) << k;
}

TEST(PathOfASheet, BadHistoriesAreRefused) {
  const HeldSheet sheet(5, rubbing_cloth());
  auto solver = EquilibriumSolver::make(sheet.model, sheet.boundary).value();
  State state = sheet.start;
  History history = sheet.model.never_strained();
  history.state.conservativeResize(history.state.size() - 1);
  EXPECT_FALSE(solver.solve(sheet.parameters, {}, state, {}, &history));
  history = sheet.model.never_strained();
  history.duration_s = -1.0;
  EXPECT_FALSE(solver.solve(sheet.parameters, {}, state, {}, &history));
  sheet.hold({0.02, 0.0}, state);
  ASSERT_TRUE(solver.solve(sheet.parameters, {}, state));
  Eigen::MatrixXd change;
  EXPECT_FALSE(sensitivity_along_path(solver, sheet.parameters, state, nullptr, change));
}

}  // namespace
}  // namespace tenter::mechanics::testing
