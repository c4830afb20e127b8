// SPDX-License-Identifier: GPL-3.0-or-later
// An energy that is convex (thesis 4.2.3, 4.3.3), one of three ways:
//
//   every_step       the fit of all curves to all captures goes on with every step projected, so it
//                    ends at the best convex parameters nearby
//   afterwards       the fitted parameters are projected once, by the data's own distance J'WJ
//   by_construction  curves of more than one control point are replaced by the nearest
//                    convex_spline, whose coefficients are not negative, and all is fitted again
//
//   auto convex = sheet_convexity(model, found, work);
//
// Where nothing convex is found the model stays as it was, and the message says why.
#pragma once

#include "server/jobs/sheet_fit/requests/requests.h"

namespace tenter::jobs {

/// Errors as ConvexityConstraints::make(). `cancelled` where stopped.
Expected<ConvexFound> sheet_convexity(model::Model& model, const SheetFindings& found,
                                      const RequestWork& work);

}  // namespace tenter::jobs
