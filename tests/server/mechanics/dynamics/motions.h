// SPDX-License-Identifier: GPL-3.0-or-later
// Sheets in motion: what tests of time steps start from.
#pragma once

#include "server/mechanics/dynamics/motion_energy.h"
#include "server/mechanics/dynamics/walk.h"
#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {

/// A 0.1 m square, soft enough for its waves to be resolved by steps of milliseconds; gravity along
/// -z. Held at its two corners of v = 0.
struct Swing {
  explicit Swing(int nodes_a_side = 5, double stretch_N_m = 20.0, double area_density_kg_m2 = 0.2);

  Sheet sheet;
  Boundary boundary;
  Loads loads;
  State flat_state;

  TimeStepper stepper(std::vector<Obstacle> obstacles = {}) const;
  /// In its plane, horizontal, with a smooth velocity.
  Motion thrown() const;
  /// Material and loads, without what moves.
  double potential_J(const State& state) const;
  double energy_J(const Motion& motion) const;
  Script constant() const;
};

/// Steps of one length, every one of which must be good.
WalkEnd walked(TimeStepper& stepper, const Eigen::VectorXd& parameters, const Script& script,
               double until_s, double step_s, const StepOptions& options, Motion& motion);

}  // namespace tenter::mechanics::testing
