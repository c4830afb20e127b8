// SPDX-License-Identifier: GPL-3.0-or-later
// One step by itself: derivatives with inertia, what is refused, and the same bytes every time.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "tests/server/mechanics/dynamics/motions.h"

namespace tenter::mechanics::testing {
namespace {

/// A free clip with weight, inertia of everything: gradient and stiffness against differences.
TEST(Inertia, DerivativesByTheUnknowns) {
  Swing swing(4, 5.0);
  swing.boundary.held = {0};
  Pose pose;
  pose.position_m = Eigen::Vector3d(0.05, 0.1, 0.0);
  Clip bar = clip_on("bar", {12, 13, 14, 15}, swing.flat_state.x, pose);
  bar.is_free = true;
  bar.mass_kg = 0.02;
  bar.centre_of_mass_m = Eigen::Vector3d(0.03, 0.04, 0.02);
  swing.boundary.clips = {bar};
  swing.flat_state.clips = {pose};
  Motion motion = swing.thrown();
  motion.velocity_m_s.tail<3>() << 0.4, -0.2, 0.7;
  StepStart start;
  start_step(TimeScheme::implicit_euler, swing.boundary, motion, 0.02, start);
  Inertia inertia;
  inertia.set(swing.boundary, swing.loads.node_mass_kg, start);
  const Unknowns unknowns(swing.boundary, swing.sheet.model.matrix());
  const Contact none;
  const Potential potential(swing.sheet.model, swing.sheet.parameters, swing.boundary, unknowns,
                            swing.loads, none, nullptr, nullptr, &inertia);
  State at = swing.flat_state;
  at.x = shaken(at.x, 3e-3, 7);
  at.clips[0].rotation = rotation_of({0.2, -0.3, 0.1});
  place_clips(swing.boundary, at);
  PotentialValue value;
  ASSERT_TRUE(potential.evaluate_with_stiffness(at, 0.0, value));
  const double slope_scale = value.by_unknown.lpNorm<Eigen::Infinity>();
  ASSERT_GT(slope_scale, 1e-3);
  constexpr double kStep = 1e-6;
  const int n = unknowns.count();
  State moved = at;
  PotentialValue low, high;
  for (int j = 0; j < n; ++j) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
    step[j] = 1.0;
    unknowns.move(at, step, kStep, moved);
    ASSERT_TRUE(potential.evaluate(moved, high));
    unknowns.move(at, step, -kStep, moved);
    ASSERT_TRUE(potential.evaluate(moved, low));
    EXPECT_NEAR((high.energy_J - low.energy_J) / (2.0 * kStep), value.by_unknown[j],
                1e-6 * slope_scale);
    // turned axes turn their torques: the matrix is symmetric only where the net torque is zero, so
    // turns are compared on their energy alone
    if (j >= n - 6) {
      unknowns.move(at, step, 1e-4, moved);
      const double up = potential.energy_J(moved);
      unknowns.move(at, step, -1e-4, moved);
      const double curvature = (up + potential.energy_J(moved) - 2.0 * value.energy_J) / 1e-8;
      const double entry = value.stiffness[static_cast<std::size_t>(unknowns.pattern().slot(j, j))];
      EXPECT_NEAR(curvature, entry, 1e-4 * std::abs(entry) + 1e-6);
      continue;
    }
    for (int i = j; i < n - 6; ++i) {
      const int slot = unknowns.pattern().slot(i, j);
      if (slot < 0) continue;
      const double difference = (high.by_unknown[i] - low.by_unknown[i]) / (2.0 * kStep);
      EXPECT_NEAR(difference, value.stiffness[static_cast<std::size_t>(slot)], 1e-4);
    }
  }
}

TEST(TimeStep, SaysWhatDoesNotFit) {
  const Swing swing;
  auto stepper = swing.stepper();
  struct Case {
    std::function<void(StepInput&, Motion&, StepOptions&)> spoil;
    std::string says;
  };
  const Case cases[] = {
      {[](auto& in, auto&, auto&) { in.duration_s = 0.0; }, "must be positive"},
      {[](auto& in, auto&, auto&) { in.duration_s = std::nan(""); }, "must be positive"},
      {[](auto& in, auto&, auto&) { in.loads.node_mass_kg.resize(0); }, "no masses"},
      {[](auto& in, auto&, auto&) { in.obstacles.emplace_back(Plane{}); }, "obstacles"},
      {[](auto& in, auto&, auto&) { in.clips.emplace_back(); }, "clips"},
      {[](auto&, auto& m, auto&) { m.velocity_m_s.conservativeResize(3); }, "velocities"},
      {[](auto&, auto& m, auto&) { m.velocity_m_s[5] = std::nan(""); }, "velocities"},
      {[](auto&, auto& m, auto&) { m.at.x[5] = std::nan(""); }, "position is no number"},
      {[](auto&, auto&, auto& o) { o.tolerance_N = -1.0; }, "tolerance_N"},
      {[](auto&, auto&, auto& o) { o.largest_error_m = -1.0; }, "largest_error_m"}};
  for (const Case& one : cases) {
    StepInput input{0.01, swing.loads, {}, {}};
    Motion motion = swing.thrown();
    StepOptions options;
    one.spoil(input, motion, options);
    const auto step = stepper.step(swing.sheet.parameters, input, motion, options);
    ASSERT_FALSE(step) << one.says;
    EXPECT_NE(step.error().message.find(one.says), std::string::npos) << step.error().message;
  }
}

TEST(TimeStep, GivesTheSameBytesAndAFailedOneLeavesTheMotion) {
  const Swing swing;
  Motion ends[2];
  for (Motion& motion : ends) {
    auto stepper = swing.stepper();
    motion = swing.thrown();
    walked(stepper, swing.sheet.parameters, swing.constant(), 0.05, 0.005, {}, motion);
  }
  EXPECT_EQ(ends[0].at.x, ends[1].at.x);
  EXPECT_EQ(ends[0].velocity_m_s, ends[1].velocity_m_s);

  auto stepper = swing.stepper();
  Motion motion = ends[0];
  StepOptions hopeless;
  hopeless.max_iterations = 0;
  hopeless.tolerance_N = 1e-13;
  const auto step =
      stepper.step(swing.sheet.parameters, {0.05, swing.loads, {}, {}}, motion, hopeless);
  ASSERT_TRUE(step) << step.error().message;
  EXPECT_FALSE(step->is_good(hopeless));
  EXPECT_EQ(step->last.end, MinimiseEnd::out_of_steps);
  EXPECT_EQ(motion.at.x, ends[0].at.x);
  EXPECT_EQ(motion.time_s, ends[0].time_s);

  StepLength length{.largest_s = 0.01, .smallest_s = 0.004};
  const auto end =
      walk_until(stepper, swing.sheet.parameters, swing.constant(), 0.1, hopeless, length, motion);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->how, WalkEnd::How::too_small);
  EXPECT_NE(end->reason.find("iterations"), std::string::npos) << end->reason;
}

}  // namespace
}  // namespace tenter::mechanics::testing
