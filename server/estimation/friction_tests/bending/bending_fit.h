// SPDX-License-Identifier: GPL-3.0-or-later
// Stiffness and friction of bending from spirals and cantilevers (thesis 5.3.3, table 5.2).
//
// The papers take k1, k2 from the cantilevers as if these had no friction, then sigma_max and tau
// from the spirals: that is the start (anchored_start.h; `papers` of the estimate). A strip that
// bends from flat works against friction too, which makes it look stiffer; so the result is a fit
// of all five to both at once, each along its own way, so that the strips hang where their points
// were seen (contour/contour_errors.h). Without cantilevers the same, from spirals alone: where
// those do not tell the stiffness, the words say so.
//
// One sense of curvature at a time (by_sense of strip_test.h).
//
//   Expected<BendingEstimate> found = fit_bending(by_sense(tests)[0], "bend_v");
//
// bad_input: see check() of strip_test.h; a measure that is not a bending; fewer samples left than
// parameters. Cost: 40 strips 1 s, with profiles of the likelihood 18 s and more. Pure; any thread.
#pragma once

#include <string_view>
#include <vector>

#include "server/estimation/friction_tests/bending/torque_samples.h"
#include "server/estimation/friction_tests/friction_estimate.h"

namespace tenter::estimation {

struct BendingEstimate {
  FrictionEstimate friction;
  FrictionValues cantilever;             ///< k1 and k2 as the papers take them; 0 without any
  std::vector<ProfileSamples> profiles;  ///< one a strip
  std::vector<double> predicted;         ///< the model's mean strain over each sample (1/m)
  int left_out = 0;                      ///< samples where gravity and elasticity oppose
};

Expected<BendingEstimate> fit_bending(const BendingTests& tests, std::string_view measure,
                                      const FrictionFitOptions& options = {});

/// k1 and k2 from cantilevers alone (Clapp et al., cantilever/moment_errors.h): torque against
/// curvature along the strip's own shape. a, b and tau are zero, fixed, and not told: a strip that
/// was never rolled goes one way. What friction resists on that way is in k1 and k2, so that the
/// elastic ones are smaller. `start`, `predicted` and `snapped` stay empty. bad_input: see check()
/// with BendingProtocol::cantilevers.
Expected<BendingEstimate> fit_cantilevers(const BendingTests& tests, std::string_view measure,
                                          const FrictionFitOptions& options = {});

}  // namespace tenter::estimation
