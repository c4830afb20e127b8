// SPDX-License-Identifier: GPL-3.0-or-later
// How often the fit of all curves to all captures ends where the stages ended, from random starts:
// the costs in their order are the waterfall.
//
//   auto starts = sheet_starts(model, found, work);        // found.after: rests of `model`
//
// Starts are the fitted values times factors up to kWidest either way, curves with the control
// points and ranges that the stages chose. Frames start where they were measured, not from the
// stages' rests. Where a start ends lower by more than kShare, its values go into `model`.
// The same bytes for any number of threads.
#pragma once

#include "server/jobs/sheet_fit/requests/requests.h"

namespace tenter::jobs {

inline constexpr double kWidest = 10.0;
inline constexpr double kShare = 0.01;
inline constexpr int kStartFrames = 8;  ///< of a capture

/// `cancelled` where stopped; errors as multi_start().
Expected<StartsFound> sheet_starts(model::Model& model, const SheetFindings& found,
                                   const RequestWork& work);

}  // namespace tenter::jobs
