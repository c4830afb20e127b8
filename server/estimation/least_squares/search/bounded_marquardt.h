// SPDX-License-Identifier: GPL-3.0-or-later
// Levenberg and Marquardt's steps, each the exact minimum of its linear problem within the bounds:
//
//   d = argmin |r + J d|^2 + mu |D d|^2     lower <= x + d <= upper,  D: lengths of J's columns
//
// Where forces are nearly linear in stiffnesses that may not be negative, one such step finds both
// the stiffnesses and which of them are zero; a step that is cut off at bounds (Ceres) needs a line
// search of whole equilibria for that, and many short steps. mu falls to a tenth where the cost
// does what the linear problem said, and rises where it does not or where the model has no
// equilibrium. The end: an accepted step, or one that is not taken any more because no more is
// promised of it with mu = 0, lowers the cost by less than `tolerance`.
//
//   SearchOptions options;
//   auto result = minimise_by_bounded_marquardt(objective, lower, upper, options, x);
//
// One evaluation a step. One thread; deterministic.
#pragma once

#include "server/estimation/least_squares/objective.h"
#include "server/estimation/least_squares/search/search_result.h"

namespace tenter::estimation {

/// `x`: start and result, scaled. Bounds of each: infinite where there is none; the start is put
/// within them. `on_iteration` hears of the start first, then of each step that is taken, with the
/// number of steps tried.
SearchResult minimise_by_bounded_marquardt(Objective& objective, const Eigen::VectorXd& lower,
                                           const Eigen::VectorXd& upper,
                                           const SearchOptions& options, Eigen::VectorXd& x);

}  // namespace tenter::estimation
