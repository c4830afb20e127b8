// SPDX-License-Identifier: GPL-3.0-or-later
// How fast solutions approach a fine one, and what the estimated error says of that.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/mechanics/dynamics/motions.h"

namespace tenter::mechanics::testing {
namespace {

constexpr double kSwing_s = 0.032;

StepOptions tight(TimeScheme scheme) {
  StepOptions options;
  options.scheme = scheme;
  options.tolerance_N = 1e-10;
  return options;
}

class Orders : public ::testing::Test {
 protected:
  Motion run(double step_s, TimeScheme scheme) {
    auto stepper = swing_.stepper();
    Motion motion = swing_.thrown();
    walked(stepper, swing_.sheet.parameters, swing_.constant(), kSwing_s, step_s, tight(scheme),
           motion);
    return motion;
  }
  Swing swing_{4};
};

TEST_F(Orders, AreOneAndTwo) {
  const Motion fine = run(kSwing_s / 1024, TimeScheme::bdf2);
  const double way_m = (fine.at.x - swing_.flat_state.x).lpNorm<Eigen::Infinity>();
  ASSERT_GT(way_m, 0.01) << "it moves by a tenth of itself";
  for (const auto& [scheme, wanted] :
       {std::pair{TimeScheme::implicit_euler, 1.0}, std::pair{TimeScheme::bdf2, 2.0}}) {
    // waves of implicit Euler die out early: its steps have to resolve them
    const int coarse = scheme == TimeScheme::bdf2 ? 64 : 256;
    double error[2], speed_error[2];
    for (int k = 0; k < 2; ++k) {
      const Motion motion = run(kSwing_s / (k == 0 ? coarse : 2 * coarse), scheme);
      error[k] = (motion.at.x - fine.at.x).norm();
      speed_error[k] = (motion.velocity_m_s - fine.velocity_m_s).norm();
    }
    EXPECT_NEAR(order(error[0], error[1]), wanted, 0.2) << error[0] << " " << error[1];
    EXPECT_NEAR(order(speed_error[0], speed_error[1]), wanted, 0.25);
    EXPECT_LT(error[1], 0.05 * way_m * std::sqrt(static_cast<double>(fine.at.x.size())));
  }
}

/// Steps of changing length keep the order, and the estimate of a step is what it is off by.
TEST_F(Orders, StepsThatFollowTheErrorKeepToIt) {
  const Motion fine = run(kSwing_s / 1024, TimeScheme::bdf2);
  double error_m[2];
  int steps[2];
  for (int k = 0; k < 2; ++k) {
    auto stepper = swing_.stepper();
    Motion motion = swing_.thrown();
    StepLength length{.largest_s = 0.01, .error_m = k == 0 ? 1e-6 : 1e-8};
    const auto end = walk_until(stepper, swing_.sheet.parameters, swing_.constant(), kSwing_s,
                                tight(TimeScheme::bdf2), length, motion);
    ASSERT_TRUE(end) << end.error().message;
    ASSERT_EQ(end->how, WalkEnd::How::complete) << end->reason;
    EXPECT_LE(end->last.error_m, length.error_m);
    EXPECT_GT(end->error_m, 0.0);
    error_m[k] = (motion.at.x - fine.at.x).norm() / std::sqrt(motion.at.x.size() / 3.0);
    steps[k] = end->steps;
    EXPECT_LT(error_m[k], 30.0 * end->error_m);
    EXPECT_GT(error_m[k], 0.03 * end->error_m);
  }
  // a hundredth of the error of a step of order 3 takes 100^(1/3) times as many
  EXPECT_NEAR(static_cast<double>(steps[1]) / steps[0], std::cbrt(100.0), 1.5);
  EXPECT_LT(error_m[1], 0.15 * error_m[0]);
}

TEST_F(Orders, TheEstimateIsTheErrorOfOneStep) {
  // from a smooth motion on its way, against many short steps
  for (const auto& [scheme, wanted] :
       {std::pair{TimeScheme::implicit_euler, 2.0}, std::pair{TimeScheme::bdf2, 3.0}}) {
    double estimate[2], truth[2];
    for (int k = 0; k < 2; ++k) {
      const double dt = k == 0 ? 4e-4 : 2e-4;
      auto stepper = swing_.stepper();
      Motion motion = swing_.thrown();
      StepOptions options = tight(TimeScheme::bdf2);
      walked(stepper, swing_.sheet.parameters, swing_.constant(), 0.004, 2e-5, options, motion);
      Motion before = motion;
      walked(stepper, swing_.sheet.parameters, swing_.constant(), 0.004 + dt, 2e-5, options,
             motion);
      Motion ahead = motion;
      walked(stepper, swing_.sheet.parameters, swing_.constant(), 0.004 + 2.0 * dt, 2e-5, options,
             ahead);
      motion.last_step_s = dt;
      motion.last_points_m = before.at.x;
      motion.last_velocity_m_s = before.velocity_m_s;
      options.scheme = scheme;
      const auto end = walked(stepper, swing_.sheet.parameters, swing_.constant(), 0.004 + 2.0 * dt,
                              dt, options, motion);
      double squared = 0.0, mass = 0.0;
      for (int n = 0; n < swing_.sheet.nodes(); ++n) {
        if (n == swing_.boundary.held[0] || n == swing_.boundary.held[1]) continue;
        const double m = swing_.loads.node_mass_kg[n];
        squared += m * (motion.at.x - ahead.at.x).segment<3>(3 * n).squaredNorm();
        mass += m;
      }
      estimate[k] = end.last.error_m;
      truth[k] = std::sqrt(squared / mass);
      EXPECT_NEAR(estimate[k] / truth[k], 1.0, 0.35);
    }
    EXPECT_NEAR(order(truth[0], truth[1]), wanted, 0.35);
    EXPECT_NEAR(order(estimate[0], estimate[1]), wanted, 0.35);
  }
}

/// Short enough, one linear system per step follows the converged steps.
TEST_F(Orders, LinearisedStepsApproachTheConvergedOnes) {
  double off[2];
  for (int k = 0; k < 2; ++k) {
    const double step_s = kSwing_s / (k == 0 ? 64 : 128);
    const Motion converged = run(step_s, TimeScheme::implicit_euler);
    auto stepper = swing_.stepper();
    Motion motion = swing_.thrown();
    StepOptions options = tight(TimeScheme::implicit_euler);
    options.is_linearised = true;
    const WalkEnd end = walked(stepper, swing_.sheet.parameters, swing_.constant(), kSwing_s,
                               step_s, options, motion);
    EXPECT_EQ(end.iterations, end.steps);
    EXPECT_GT(end.last.last.net_force_N, 1e-7) << "what is left is not zero";
    off[k] = (motion.at.x - converged.at.x).norm();
    EXPECT_GT(off[k], 1e-9);
  }
  EXPECT_GT(order(off[0], off[1]), 0.8);
}

}  // namespace
}  // namespace tenter::mechanics::testing
