// SPDX-License-Identifier: GPL-3.0-or-later
// Where in the material the pins are, given a model: nobody measured the cloth at rest.
//
//   min over places X_p and an offset o of  sum |x_f(X_p) - (measured_pf + o e_v)|^2
//
// f runs over the distances between the clamps, measured is the mean of the fitted pulls, x_f what
// the model makes of the material. The offset along the pull is that of the clamps' dots from the
// edges that hold the cloth, half their difference. A pin that is left out takes no part; its place
// is where the model shows it as measured at one taut distance alone (kTautFrame).
//
//   for (...) { fit material; place_pins(states, fitted, left_out, data); }
#pragma once

#include <vector>

#include "server/mechanics/conditions/boundary.h"
#include "tests/bench/knit/knit_data.h"

namespace tenter::bench {

/// `states`: of each frame of data.sequence; `left_out`: a pin, or -1. Moves the points of the
/// sequence in the material, and along the pull what was measured of them.
void place_pins(const std::vector<mechanics::State>& states, const std::vector<int>& fitted,
                int left_out, KnitData& data);

}  // namespace tenter::bench
