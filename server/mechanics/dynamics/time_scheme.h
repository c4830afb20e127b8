// SPDX-License-Identifier: GPL-3.0-or-later
// How positions and velocities at the end of a time step follow from the motion before it.
//
//   x1 = x^ + h v1,  v1 = v^ + h a1,   M a1 = -dPi/dx(x1)        so x1 minimises
//   1/(2 h^2) |x1 - x~|_M^2 + Pi(x1),  x~ = x^ + h v^            (architecture: incremental
//   potential)
//
//   implicit Euler    x^ = x0, v^ = v0, h = dt
//   BDF2              y^ = ((1 + w)^2 y0 - w^2 y_-1) / (1 + 2 w), h = dt (1 + w) / (1 + 2 w)
//                     for y = x and y = v, w = dt / dt of the step before; order 2 for steps that
//                     grow less than 1 + sqrt 2 times (Hairer, Norsett, Wanner, III.5)
//
// BDF2's first step is one of implicit Euler, whose error of one step is of second order.
//
// "Points" are the nodes and then the centre of mass of every clip: 3 numbers each.
//
// Values and pure functions; nothing allocates once the outputs have their sizes.
#pragma once

#include <Eigen/Core>

#include "server/mechanics/conditions/boundary.h"

namespace tenter::mechanics {

enum class TimeScheme { implicit_euler, bdf2 };

/// A mesh in motion at one instant, with the instant before it where there was one.
struct Motion {
  State at;
  Eigen::VectorXd velocity_m_s;  ///< of points
  double time_s = 0.0;
  double last_step_s = 0.0;  ///< 0: there was none
  Eigen::VectorXd last_points_m;
  Eigen::VectorXd last_velocity_m_s;
  /// What the material remembers (assembly/history); empty: it was pulled straight to the start.
  Eigen::VectorXd history, last_history;
};

/// At rest at t = 0.
Motion at_rest(const Boundary& boundary, State state);

/// Nodes, then centres of mass.
void points_of(const Boundary& boundary, const State& state, Eigen::VectorXd& points_m);

/// What a step of `duration_s` makes of the motion before it is solved.
struct StepStart {
  double h_s = 0.0;                          ///< dx1/dv1
  Eigen::VectorXd points_m;                  ///< x^
  Eigen::VectorXd velocity_m_s;              ///< v^
  Eigen::VectorXd target_m;                  ///< x~
  double now_share = 1.0, last_share = 0.0;  ///< y^ = now_share y0 - last_share y_-1
  Eigen::VectorXd guess_m;   ///< explicit prediction of x1, of the order of the scheme
  Eigen::VectorXd begin_m;   ///< one of second order: where to look for x1 first
  double error_share = 0.0;  ///< error of x1 is about so much of x1 - guess
  int order = 1;
};
void start_step(TimeScheme scheme, const Boundary& boundary, const Motion& motion,
                double duration_s, StepStart& start);

/// The motion at the end of the step, whose state is `end`.
void finish_step(const Boundary& boundary, const StepStart& start, double duration_s, State end,
                 Motion& motion);

}  // namespace tenter::mechanics
