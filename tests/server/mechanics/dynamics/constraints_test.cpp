// SPDX-License-Identifier: GPL-3.0-or-later
// Obstacles that stand and move, and energy limits, hold at the end of every step.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/mechanics/dynamics/motions.h"

namespace tenter::mechanics::testing {
namespace {

/// A sheet falls on a floor and lies there; the floor bears its weight.
TEST(DynamicContact, ASheetComesToRestOnAFloor) {
  Swing swing(5, 200.0);
  swing.boundary.held.clear();
  auto stepper = swing.stepper({Plane{{0.0, 0.0, -0.01}, Eigen::Vector3d::UnitZ()}});
  Motion motion = at_rest(swing.boundary, swing.flat_state);
  motion.at.x = shaken(motion.at.x, 1e-3, 3);
  StepOptions options;
  options.scheme = TimeScheme::implicit_euler;
  double lowest_m = 0.0;
  for (int step = 1; step <= 100; ++step) {
    walked(stepper, swing.sheet.parameters, swing.constant(), 0.005 * step, 0.005, options, motion);
    for (Eigen::Index z = 2; z < motion.at.x.size(); z += 3)
      lowest_m = std::min(lowest_m, motion.at.x[z]);
  }
  EXPECT_LT(lowest_m, -0.0099) << "it has come down";
  EXPECT_GE(lowest_m, -0.01 - options.contact_depth_m);
  EXPECT_LT(motion.velocity_m_s.lpNorm<Eigen::Infinity>(), 0.01);
  const double weight_N = 9.81 * swing.loads.node_mass_kg.sum();
  EXPECT_NEAR(stepper.contact_force_N(motion.at).sum(), weight_N, 0.05 * weight_N);
}

/// A cylinder comes up from below and carries the sheet along.
TEST(DynamicContact, AMovingCylinderLiftsTheSheet) {
  Swing swing(7, 200.0);
  swing.boundary.held.clear();
  Cylinder roll{{0.05, 0.05, -0.03}, Eigen::Vector3d::UnitX(), 0.02};
  auto stepper = swing.stepper({roll});
  const Script script = [&](double t) {
    Cylinder now = roll;
    now.point_m.z() += 0.5 * t;
    return StepInput{0.0, swing.loads, {}, {now}};
  };
  swing.loads.gravity_m_s2 *= 0.2;
  Motion motion = at_rest(swing.boundary, swing.flat_state);
  StepOptions options;
  for (int step = 1; step <= 30; ++step) {
    walked(stepper, swing.sheet.parameters, script, 0.004 * step, 0.004, options, motion);
    const Obstacle now = script(0.004 * step).obstacles[0];
    for (int n = 0; n < swing.sheet.nodes(); ++n)
      EXPECT_GE(gap(now, motion.at.x.segment<3>(3 * n)).value_m, -options.contact_depth_m);
  }
  double mean_z = 0.0;
  for (int n = 0; n < swing.sheet.nodes(); ++n)
    mean_z += motion.at.x[3 * n + 2] / swing.sheet.nodes();
  EXPECT_GT(mean_z, 0.0) << "gravity alone would have taken it below";
}

/// A weight falls into a strip: without a limit it stretches too far, with it at no instant.
TEST(DynamicLimits, HoldAtEveryStep) {
  const Grid grid{3, 5, 0.02, 0.1};
  const Cloth cloth = cloth_of_grid(grid, Diagonals::alternating).value();
  model::Model description = linear_model({{"soft_v", 40.0}, {"soft_u", 40.0}, {"green_uv", 10.0}});
  constexpr double kEnergyMax = 0.5 * 40.0 * 0.1 * 0.1;
  double highest[2] = {};
  for (const bool is_limited : {false, true}) {
    // the unlimited one measures against the same limit, which it does not obey
    model::EnergyLimit limit;
    limit.id = "warp";
    limit.terms = {"soft_v"};
    limit.energy_max = is_limited ? kEnergyMax : 1e3;
    limit.unit = "J/m^2";
    description.limits = {limit};
    const Sheet strip(cloth, description);
    Boundary boundary;
    boundary.held = {grid.node(0, 4), grid.node(1, 4), grid.node(2, 4)};
    Loads loads = weight(cloth.mesh, 0.2);
    for (int i = 0; i < 3; ++i) loads.node_mass_kg[grid.node(i, 0)] += 0.004;
    State state;
    state.x = placed(cloth.mesh, [](double u, double v) { return Eigen::Vector3d(u, 0.0, v); });
    auto stepper = TimeStepper::make(strip.model, boundary).value();
    Motion motion = at_rest(boundary, state);
    const Script script = [&](double) { return StepInput{0.0, loads, {}, {}}; };
    for (int step = 1; step <= 50; ++step) {
      walked(stepper, strip.parameters, script, 0.002 * step, 0.002, {}, motion);
      Eigen::VectorXd excess;
      ASSERT_EQ(strip.model.limit_excess(motion.at.x, strip.parameters, excess),
                AssemblyStatus::ok);
      highest[is_limited] = std::max(highest[is_limited], excess.maxCoeff() + limit.energy_max);
    }
  }
  EXPECT_GT(highest[0], 1.5 * kEnergyMax);
  EXPECT_LE(highest[1], (1.0 + 2e-6) * kEnergyMax);
  EXPECT_GT(highest[1], 0.999 * kEnergyMax);
}

}  // namespace
}  // namespace tenter::mechanics::testing
