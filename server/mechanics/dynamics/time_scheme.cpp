// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/dynamics/time_scheme.h"

#include <utility>

namespace tenter::mechanics {

Motion at_rest(const Boundary& boundary, State state) {
  Motion motion;
  motion.at = std::move(state);
  motion.velocity_m_s.setZero(motion.at.x.size() +
                              3 * static_cast<Eigen::Index>(boundary.clips.size()));
  return motion;
}

void points_of(const Boundary& boundary, const State& state, Eigen::VectorXd& points_m) {
  const Eigen::Index nodes = state.x.size();
  points_m.resize(nodes + 3 * static_cast<Eigen::Index>(boundary.clips.size()));
  points_m.head(nodes) = state.x;
  for (std::size_t c = 0; c < boundary.clips.size(); ++c)
    points_m.segment<3>(nodes + 3 * static_cast<Eigen::Index>(c)) =
        state.clips[c].to_space(boundary.clips[c].centre_of_mass_m);
}

// Errors of one step. x1 of implicit Euler and the guess x0 + dt v0 are off by -dt^2/2 a and
// +dt^2/2 a, so the error is half of their difference. BDF2 replaces x by its parabola through
// three instants, whose slope at the last is off by x'''/6 dt (dt + dt'), dt' the step before:
//   x - x1 = x'''/6 dt (dt + dt') h
// The guess x0 + dt v0 + dt^2/2 (v0 - v_-1)/dt' is off by x''' (dt^3/6 + dt^2 dt'/4).
void start_step(TimeScheme scheme, const Boundary& boundary, const Motion& motion,
                double duration_s, StepStart& start) {
  points_of(boundary, motion.at, start.points_m);
  const double dt = duration_s;
  start.guess_m = start.points_m + dt * motion.velocity_m_s;
  if (scheme == TimeScheme::implicit_euler || motion.last_step_s == 0.0) {
    start.h_s = dt;
    start.velocity_m_s = motion.velocity_m_s;
    start.now_share = 1.0;
    start.last_share = 0.0;
    start.order = 1;
    start.error_share = 0.5;
    start.begin_m = start.guess_m;
    if (motion.last_step_s > 0.0)
      start.begin_m +=
          (dt * dt / motion.last_step_s) * (motion.velocity_m_s - motion.last_velocity_m_s);
  } else {
    const double last = motion.last_step_s;
    const double w = dt / last;
    start.now_share = (1.0 + w) * (1.0 + w) / (1.0 + 2.0 * w);
    start.last_share = w * w / (1.0 + 2.0 * w);
    start.h_s = dt * (1.0 + w) / (1.0 + 2.0 * w);
    start.guess_m += 0.5 * dt * w * (motion.velocity_m_s - motion.last_velocity_m_s);
    start.points_m = start.now_share * start.points_m - start.last_share * motion.last_points_m;
    start.velocity_m_s =
        start.now_share * motion.velocity_m_s - start.last_share * motion.last_velocity_m_s;
    start.begin_m = start.guess_m;
    const double own = dt * (dt + last) * start.h_s / 6.0;
    const double of_guess = dt * dt * (dt / 6.0 + last / 4.0);
    start.order = 2;
    start.error_share = own / (own + of_guess);
  }
  start.target_m = start.points_m + start.h_s * start.velocity_m_s;
}

void finish_step(const Boundary& boundary, const StepStart& start, double duration_s, State end,
                 Motion& motion) {
  points_of(boundary, motion.at, motion.last_points_m);
  std::swap(motion.last_velocity_m_s, motion.velocity_m_s);
  motion.last_step_s = duration_s;
  motion.at = std::move(end);
  points_of(boundary, motion.at, motion.velocity_m_s);
  motion.velocity_m_s = (motion.velocity_m_s - start.points_m) / start.h_s;
  motion.time_s += duration_s;
}

}  // namespace tenter::mechanics
