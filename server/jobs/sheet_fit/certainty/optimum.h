// SPDX-License-Identifier: GPL-3.0-or-later
// How certain the fitted parameters are: errors and correlations of all free ones together, from
// what was compared in the fit and has a rest under the fitted model.
//
//   found.optimum = optimum(model, found, threads, 1e-7);      // `after` and `stages` are known
#pragma once

#include <vector>

#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

enum class FramesStart {
  at_rest,     ///< from the rest that `found.after` found
  as_measured  ///< from where the capture has them
};
enum class Compared { fitted, held_out };

/// Captures as the stages saw them, or those that no stage saw, without frames that have no rest.
std::vector<estimation::Sequence> compared_sequences(const SheetFindings& found,
                                                     FramesStart start = FramesStart::at_rest,
                                                     Compared which = Compared::fitted);

/// Not usable, and the message says why, where they cannot be had.
estimation::FitResult optimum(const model::Model& model, const SheetFindings& found, int threads,
                              double tolerance_N);

}  // namespace tenter::jobs
