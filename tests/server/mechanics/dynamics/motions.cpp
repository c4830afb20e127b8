// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/mechanics/dynamics/motions.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tenter::mechanics::testing {

Swing::Swing(int nodes_a_side, double stretch_N_m, double area_density_kg_m2)
    : sheet(cloth_of_grid({nodes_a_side, nodes_a_side, 0.1, 0.1}, Diagonals::alternating).value(),
            linear_model({{"green_u", stretch_N_m},
                          {"green_v", stretch_N_m},
                          {"green_uv", 0.3 * stretch_N_m},
                          {"bend_u", 1e-5},
                          {"bend_v", 1e-5},
                          {"bend_d", 1e-5}})),
      loads(weight(sheet.cloth.mesh, area_density_kg_m2)),
      flat_state{flat(sheet.cloth.mesh), {}} {
  boundary.held = {0, nodes_a_side - 1};
}

TimeStepper Swing::stepper(std::vector<Obstacle> obstacles) const {
  return TimeStepper::make(sheet.model, boundary, std::move(obstacles)).value();
}

Motion Swing::thrown() const {
  Motion motion = at_rest(boundary, flat_state);
  for (int n = 0; n < sheet.nodes(); ++n) {
    const double u = sheet.cloth.mesh.material_m(0, n) / 0.1;
    const double v = sheet.cloth.mesh.material_m(1, n) / 0.1;
    motion.velocity_m_s.segment<3>(3 * n) << 0.05 * v * v, 0.1 * v,
        v * (0.4 + 0.3 * std::sin(3.0 * u));
  }
  for (const int node : boundary.held) motion.velocity_m_s.segment<3>(3 * node).setZero();
  return motion;
}

double Swing::potential_J(const State& state) const {
  const Unknowns unknowns(boundary, sheet.model.matrix());
  const Contact none;
  return Potential(sheet.model, sheet.parameters, boundary, unknowns, loads, none).energy_J(state);
}

double Swing::energy_J(const Motion& motion) const {
  return potential_J(motion.at) + momenta(boundary, loads.node_mass_kg, motion).kinetic_J;
}

Script Swing::constant() const {
  return [this](double) { return StepInput{0.0, loads, {}, {}}; };
}

WalkEnd walked(TimeStepper& stepper, const Eigen::VectorXd& parameters, const Script& script,
               double until_s, double step_s, const StepOptions& options, Motion& motion) {
  StepLength length{.largest_s = step_s};
  auto end = walk_until(stepper, parameters, script, until_s, options, length, motion);
  if (!end) {
    ADD_FAILURE() << end.error().message;
    return {};
  }
  EXPECT_EQ(end->how, WalkEnd::How::complete) << end->reason;
  EXPECT_EQ(end->rejected, 0);
  return *end;
}

}  // namespace tenter::mechanics::testing
