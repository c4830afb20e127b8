// SPDX-License-Identifier: GPL-3.0-or-later
// How certain the fitted parameters are: errors and correlations of all free ones together, from
// what was compared in the fit and has a rest under the fitted model.
//
//   found.optimum = optimum(model, found, threads, 1e-7);      // `after` and `stages` are known
#pragma once

#include <vector>

#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

/// Fitted captures as the stages saw them, without frames that have no rest; every frame starts
/// from the rest that `found.after` found for it.
std::vector<estimation::Sequence> compared_sequences(const SheetFindings& found);

/// Not usable, and the message says why, where they cannot be had.
estimation::FitResult optimum(const model::Model& model, const SheetFindings& found, int threads,
                              double tolerance_N);

}  // namespace tenter::jobs
