// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/sequences/rig_noise.h"

#include <algorithm>

namespace tenter::twin {

void add_rig_noise(const RigNoise& noise, Random& random, estimation::Sequence& sequence) {
  const double half_N = 0.5 * noise.cord_loop_N;
  Eigen::VectorXd held = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(sequence.forces.size()));
  Eigen::VectorXd before = held;
  for (estimation::SequenceFrame& frame : sequence.frames) {
    for (Eigen::Index k = 0; k < frame.forces_N.size(); ++k) {
      const double force_N = frame.forces_N[k];
      held[k] = std::clamp(held[k] + force_N - before[k], -half_N, half_N);
      before[k] = force_N;
      frame.forces_N[k] += held[k];
    }
    if (!noise.white) continue;
    for (Eigen::Index k = 0; k < frame.points_m.cols(); ++k)
      for (int c = 0; c < 3; ++c)
        frame.points_m(c, k) +=
            sequence.points[static_cast<std::size_t>(k)].sigma_m * random.normal();
    for (Eigen::Index k = 0; k < frame.forces_N.size(); ++k)
      frame.forces_N[k] += sequence.forces[static_cast<std::size_t>(k)].sigma_N * random.normal();
  }
}

}  // namespace tenter::twin
