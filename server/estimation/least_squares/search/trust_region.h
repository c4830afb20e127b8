// SPDX-License-Identifier: GPL-3.0-or-later
// Ceres' trust region on an Objective, with bounds.
//
// Ceres meets bounds by cutting its steps off at them, which may end far from the optimum: the step
// is that of parameters which could move freely. So where a result lies at bounds that hold it back
// and a step of the others alone promises a lower cost, the held ones are taken out and the others
// go on, until none is held wrongly and nothing is promised.
//
// A point without an equilibrium shortens the step. One thread.
#pragma once

#include <string>

#include "server/estimation/least_squares/objective.h"
#include "server/estimation/least_squares/search/search_result.h"

namespace tenter::estimation {

struct TrustRegionResult {
  bool converged = false;
  bool stopped = false;  ///< by on_iteration
  bool failed = false;   ///< the start has no derivatives: nothing was done
  int iterations = 0;
  std::string message;
};

/// `x`: start and result, scaled. Bounds of each: infinite where there is none.
TrustRegionResult minimise_by_trust_region(Objective& objective, const Eigen::VectorXd& lower,
                                           const Eigen::VectorXd& upper,
                                           const SearchOptions& options, Eigen::VectorXd& x);

}  // namespace tenter::estimation
