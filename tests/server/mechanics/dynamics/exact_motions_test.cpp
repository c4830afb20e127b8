// SPDX-License-Identifier: GPL-3.0-or-later
// Motions that are known without a mesh: free fall, a pendulum, a body that nothing acts on.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/server/mechanics/dynamics/motions.h"

namespace tenter::mechanics::testing {
namespace {

constexpr double kGravity = 9.81;
const TimeScheme kSchemes[] = {TimeScheme::implicit_euler, TimeScheme::bdf2};

/// Implicit Euler falls by g dt^2 (1 + 2 + ... + n) in n steps; BDF2 is exact on a parabola once it
/// has two instants of it.
TEST(FreeFall, IsTheSumOfTheScheme) {
  Swing swing;
  swing.boundary.held.clear();
  auto stepper = swing.stepper();
  StepOptions options;
  options.tolerance_N = 1e-10;
  constexpr double dt = 0.01;
  constexpr int kSteps = 20;
  const double end_s = kSteps * dt;
  const double parabola_m = -0.5 * kGravity * end_s * end_s;
  for (const TimeScheme scheme : kSchemes) {
    options.scheme = scheme;
    Motion motion = at_rest(swing.boundary, swing.flat_state);
    double wanted_m = -kGravity * dt * dt * kSteps * (kSteps + 1) / 2;
    if (scheme == TimeScheme::bdf2) {
      wanted_m = parabola_m;
      motion.last_step_s = dt;
      motion.last_points_m = motion.at.x;
      motion.last_velocity_m_s = motion.velocity_m_s;
      for (Eigen::Index z = 2; z < motion.at.x.size(); z += 3) {
        motion.last_points_m[z] -= 0.5 * kGravity * dt * dt;
        motion.last_velocity_m_s[z] += kGravity * dt;
      }
    }
    walked(stepper, swing.sheet.parameters, swing.constant(), end_s, dt, options, motion);
    const Eigen::VectorXd fallen = motion.at.x - swing.flat_state.x;
    for (Eigen::Index n = 0; n < fallen.size(); n += 3)
      EXPECT_NEAR((fallen.segment<3>(n) - Eigen::Vector3d(0, 0, wanted_m)).norm(), 0.0,
                  1e-9 * std::abs(parabola_m));
    EXPECT_NEAR(motion.velocity_m_s[2], -kGravity * end_s, 1e-9 * kGravity * end_s);
  }
}

/// Two triangles that turn about two held corners: a pendulum of length 0.1 m, let go horizontally.
/// Its angle against a fine solution of phi'' = g/l cos phi.
TEST(Pendulum, ComesToItsAngleWithTheOrderOfTheScheme) {
  Sheet plate(cloth_of_grid({2, 2, 0.1, 0.1}, Diagonals::one).value(),
              linear_model({{"green_u", 1e6}, {"green_v", 1e6}, {"green_uv", 1e6}}));
  Boundary boundary;
  boundary.held = {0, 1};
  const Loads loads = weight(plate.cloth.mesh, 0.2);
  const Script script = [&](double) { return StepInput{0.0, loads, {}, {}}; };
  const double end_s = 0.25;
  double angle = 0.0, rate = 0.0;  // below the horizontal
  constexpr int kFine = 20000;
  for (int i = 0; i < kFine; ++i) {  // leapfrog
    const double h = end_s / kFine;
    rate += 0.5 * h * kGravity / 0.1 * std::cos(angle);
    angle += h * rate;
    rate += 0.5 * h * kGravity / 0.1 * std::cos(angle);
  }
  ASSERT_GT(angle, 2.0) << "it has swung through";
  for (const TimeScheme scheme : kSchemes) {
    double error[2];
    for (int fine = 0; fine < 2; ++fine) {
      auto stepper = TimeStepper::make(plate.model, boundary).value();
      Motion motion = at_rest(boundary, {flat(plate.cloth.mesh), {}});
      StepOptions options;
      options.scheme = scheme;
      options.tolerance_N = 1e-9;
      walked(stepper, plate.parameters, script, end_s, fine ? 0.00125 : 0.0025, options, motion);
      const Eigen::Vector3d bob = motion.at.x.segment<3>(6);
      EXPECT_NEAR(std::hypot(bob.y(), bob.z()), 0.1, 1e-6);
      error[fine] = std::abs(std::atan2(-bob.z(), bob.y()) - angle);
    }
    const double wanted = scheme == TimeScheme::bdf2 ? 2.0 : 1.0;
    EXPECT_NEAR(order(error[0], error[1]), wanted, 0.15) << error[0] << " " << error[1];
    EXPECT_LT(error[1], scheme == TimeScheme::bdf2 ? 1e-3 : 5e-2);
  }
}

/// Nothing acts from outside: momentum stays, whatever goes on inside; the moment of momentum to
/// the order of the scheme.
TEST(FreeBody, KeepsItsMomentum) {
  Swing swing;
  swing.boundary.held.clear();
  swing.loads.gravity_m_s2.setZero();
  auto stepper = swing.stepper();
  Motion start = swing.thrown();
  for (int n = 0; n < swing.sheet.nodes(); ++n) {  // and it turns about its middle
    const Eigen::Vector3d arm = start.at.x.segment<3>(3 * n) - Eigen::Vector3d(0.05, 0.05, 0.0);
    start.velocity_m_s.segment<3>(3 * n) += Eigen::Vector3d(1.0, 2.0, 3.0).cross(arm);
  }
  const Momenta before = momenta(swing.boundary, swing.loads.node_mass_kg, start);
  ASSERT_GT(before.momentum_kg_m_s.norm(), 1e-5);
  ASSERT_GT(before.angular_kg_m2_s.norm(), 1e-6);
  StepOptions options;
  options.tolerance_N = 1e-11;
  for (const TimeScheme scheme : kSchemes) {
    options.scheme = scheme;
    double lost[2];
    for (int fine = 0; fine < 2; ++fine) {
      Motion motion = start;
      walked(stepper, swing.sheet.parameters, swing.constant(), 0.04, fine ? 0.0005 : 0.001,
             options, motion);
      const Momenta after = momenta(swing.boundary, swing.loads.node_mass_kg, motion);
      EXPECT_LT((after.momentum_kg_m_s - before.momentum_kg_m_s).norm(),
                1e-8 * before.momentum_kg_m_s.norm());
      lost[fine] = (after.angular_kg_m2_s - before.angular_kg_m2_s).norm();
    }
    EXPECT_LT(lost[1], 0.05 * before.angular_kg_m2_s.norm());
    EXPECT_GT(order(lost[0], lost[1]), scheme == TimeScheme::bdf2 ? 1.6 : 0.8);
  }
}

/// A rigid clip with its weight aside of the axis, on cloth that hardly bends: its swing is that of
/// the same mass in nodes.
TEST(FreeClip, FallsAsItsMassDoes) {
  Swing swing;
  swing.boundary.held.clear();
  const int last = swing.sheet.nodes() - 1;
  Pose pose;
  pose.position_m = Eigen::Vector3d(0.05, 0.1, 0.0);
  Clip bar =
      clip_on("bar", {last - 4, last - 3, last - 2, last - 1, last}, swing.flat_state.x, pose);
  bar.is_free = true;
  bar.mass_kg = 0.003;
  bar.centre_of_mass_m = Eigen::Vector3d(0.03, 0.02, 0.01);
  swing.boundary.clips = {bar};
  swing.flat_state.clips = {pose};
  auto stepper = swing.stepper();
  Motion motion = at_rest(swing.boundary, swing.flat_state);
  StepOptions options;
  options.scheme = TimeScheme::implicit_euler;
  options.tolerance_N = 1e-12;
  constexpr double dt = 0.005;
  walked(stepper, swing.sheet.parameters, swing.constant(), 10 * dt, dt, options, motion);
  const double wanted_m = -kGravity * dt * dt * 55.0;
  EXPECT_NEAR(motion.at.clips[0].position_m.z(), wanted_m, 1e-9 * std::abs(wanted_m));
  EXPECT_NEAR((motion.at.clips[0].rotation - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-8);
  EXPECT_NEAR(motion.velocity_m_s[motion.velocity_m_s.size() - 1], -kGravity * 10 * dt, 1e-8);
}

}  // namespace
}  // namespace tenter::mechanics::testing
