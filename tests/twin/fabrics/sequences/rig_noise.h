// SPDX-License-Identifier: GPL-3.0-or-later
// What the rig's instruments make of true values (thesis 3.2.3): force sensors repeat to 3 mN,
// cameras to 0.075 mm, and cords that run over pulleys hold back up to 0.1 N between pulling and
// releasing.
//
//   force      F + h + noise       h follows dF, held within -half and +half of the cords' loop
//   position   x + noise           white, each coordinate of its own
//
// The standard deviations are those of the sequence's channels. Missing values stay missing.
#pragma once

#include "server/estimation/sequences/sequence.h"
#include "tests/twin/random.h"

namespace tenter::twin {

struct RigNoise {
  bool white = true;
  double cord_loop_N = 0.0;  ///< 0.1 as measured by the thesis; 0: cords without friction
};

/// Reads the frames in their order; each force channel has a cord of its own.
void add_rig_noise(const RigNoise& noise, Random& random, estimation::Sequence& sequence);

}  // namespace tenter::twin
