// SPDX-License-Identifier: GPL-3.0-or-later
// Every variant of every effect through the score test: candidates, threshold, a row an effect.
//
// u of each candidate is T over its own 95th null percentile; the threshold is the 95th percentile
// over the null twins of the largest u of the catalogue, so that the chance of any false alarm is 5
// % (design, step 5). Variants with a finer grid get a closer look where their coarse one did best.
//
//   const auto source = [&](const Gathering& g, Ground& ground, Eigen::MatrixXd& columns) {...};
//   screen_catalogue(fitted, excitation, source, options, result);
//
// Pure; one thread beside what the source uses.
#pragma once

#include <functional>

#include "server/diagnosis/screening/candidate.h"
#include "server/diagnosis/screening/gathering.h"
#include "server/diagnosis/screening/score_test.h"

namespace tenter::diagnosis {

/// Columns of the gathered model's Jacobian at the fit, all that Gathering::place answers, and the
/// ground that they stand on (settled), in the same coordinates. False where there are none.
using ColumnSource = std::function<bool(const Gathering&, Ground&, Eigen::MatrixXd& columns)>;

/// Fills candidates and table; lack_of_fit and expected_chi2 are the caller's.
void screen_catalogue(const model::Model& fitted, const Excitation& excitation,
                      const ColumnSource& source, const ScreenOptions& options, Screen& result);

}  // namespace tenter::diagnosis
