// SPDX-License-Identifier: GPL-3.0-or-later
// Where energy goes: a mesh in motion never has more of it than was put in.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/mechanics/dynamics/motions.h"

namespace tenter::mechanics::testing {
namespace {

TEST(Energy, OfASwingingSheetNeverGrowsAndIsLostLessWithShorterSteps) {
  Swing swing(7, 200.0);
  for (const TimeScheme scheme : {TimeScheme::implicit_euler, TimeScheme::bdf2}) {
    double lost_J[2];
    for (int fine = 0; fine < 2; ++fine) {
      auto stepper = swing.stepper();
      Motion motion = swing.thrown();
      StepOptions options;
      options.scheme = scheme;
      options.tolerance_N = 1e-8;
      const double kinetic_J = momenta(swing.boundary, swing.loads.node_mass_kg, motion).kinetic_J;
      ASSERT_GT(kinetic_J, 1e-5);
      const double first_J = swing.energy_J(motion);
      double before_J = first_J;
      for (int step = 1; step <= 30; ++step) {
        walked(stepper, swing.sheet.parameters, swing.constant(), 0.004 * step,
               fine ? 0.002 : 0.004, options, motion);
        const double now_J = swing.energy_J(motion);
        // each step of BDF2 has its own measure of energy: what it returns is a small part
        const double slack_J = scheme == TimeScheme::bdf2 ? 0.05 * kinetic_J : 1e-7 * kinetic_J;
        EXPECT_LE(now_J, before_J + slack_J) << step;
        EXPECT_LE(now_J, first_J + 1e-7 * kinetic_J) << step;
        before_J = now_J;
      }
      lost_J[fine] = first_J - before_J;
      EXPECT_GT(lost_J[fine], 0.0);
    }
    EXPECT_LT(lost_J[1], 0.9 * lost_J[0]);
  }
}

/// A bar carries the upper edge aside and back: energy comes in as its work, and no other way.
TEST(Energy, ComesInAsTheWorkOfAMovingClip) {
  Swing swing(5, 200.0);
  swing.boundary.held.clear();
  Pose pose;
  pose.position_m = Eigen::Vector3d(0.05, 0.0, 0.0);
  swing.boundary.clips = {clip_on("bar", {0, 1, 2, 3, 4}, swing.flat_state.x, pose)};
  swing.flat_state.clips = {pose};
  const auto bar_at = [&](double t) {
    Pose now = pose;
    now.position_m.x() += 0.05 * std::sin(20.0 * t);
    now.rotation = rotation_of(Eigen::Vector3d(0.0, 3.0 * t, 0.0));
    return now;
  };
  const Script script = [&](double t) { return StepInput{0.0, swing.loads, {bar_at(t)}, {}}; };
  auto stepper = swing.stepper();
  Motion motion = at_rest(swing.boundary, swing.flat_state);
  StepOptions options;
  options.scheme = TimeScheme::implicit_euler;
  options.tolerance_N = 1e-9;
  double energy_J = swing.energy_J(motion), work_J = 0.0, moved_J = 0.0;
  const double first_J = energy_J;
  for (int step = 1; step <= 60; ++step) {
    const WalkEnd end =
        walked(stepper, swing.sheet.parameters, script, 0.002 * step, 0.002, options, motion);
    const double now_J = swing.energy_J(motion);
    EXPECT_LE(now_J - energy_J, end.work_J + 1e-9) << step;
    work_J += end.work_J;
    moved_J += std::abs(end.work_J);
    energy_J = now_J;
  }
  EXPECT_GT(moved_J, 1e-4);
  EXPECT_LT(energy_J - first_J, work_J);
  EXPECT_EQ(motion.at.clips[0].position_m, bar_at(0.12).position_m);
}

}  // namespace
}  // namespace tenter::mechanics::testing
