// SPDX-License-Identifier: GPL-3.0-or-later
// Stiffness and friction of one strain from load-unload loops (thesis fig. 5.1, 5.3): k1, k2, a, b,
// tau, as from hanging weights (stretch/hanging_weights.h), with the strain imposed and the load
// read.
//
// Where no noise of the loads is given, or the fit misses them by more than that (a model of five
// numbers and a real cloth), it is that of the fit's own residuals: intervals then say what the
// model can be held to, with neighbours counted as the dependent readings that they are
// (least_squares/covariance.h).
//
//   Expected<LoopEstimate> found = fit_loops(table, "green_v");
//
// bad_input: see check() of loop_table.h; a measure that is not a stretch. Cost: 1,000 readings 10
// ms a fit, 100 of them with profiles. Pure; any thread.
#pragma once

#include <string_view>

#include "server/estimation/friction_tests/friction_estimate.h"
#include "server/estimation/friction_tests/loops/loop_table.h"

namespace tenter::estimation {

struct LoopEstimate {
  FrictionEstimate friction;       ///< noise: of one load, as the fit took it (N/m)
  bool noise_is_from_fit = false;  ///< else it is the one that was given
  double missed_share = 0.0;       ///< rms of what the model misses over rms of the loads
  double lost_share = 0.0;         ///< of the work of loading, as read
  double lost_share_of_model = 0.0;
};

Expected<LoopEstimate> fit_loops(const LoopTable& table, std::string_view measure,
                                 const FrictionFitOptions& options = {});

}  // namespace tenter::estimation
