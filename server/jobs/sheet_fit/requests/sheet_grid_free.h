// SPDX-License-Identifier: GPL-3.0-or-later
// The fit without the grid's error (estimation/staged/refit), where it was asked for: between the
// stages and the other requests.
//
//   auto found_then = sheet_grid_free(model, found, options, work);
//   ...                                // all requests and intervals see captures without the error
//   put_back_grid_error(found);        // readings as they were measured, predictions without it
//
// After the first, the sequences of all inputs are those that the model was fitted to: measured
// values less the estimate, and its share in their sigmas. After the second they are as captured,
// and found.after is what the fitted model shows on a grid without error, so that documents show
// what was read.
#pragma once

#include "server/estimation/staged/staged_fit.h"
#include "server/jobs/sheet_fit/requests/requests.h"

namespace tenter::jobs {

/// `model` is changed, and found.inputs, found.stages, found.stage_terms. `how`: as the stages
/// were fitted, which are done once more. Errors: as grid_free_fit(), with the name of the capture;
/// cancelled.
Expected<GridFreeFound> sheet_grid_free(model::Model& model, SheetFindings& found,
                                        const estimation::StagedOptions& how,
                                        const RequestWork& work);

/// Nothing where it was not asked for.
void put_back_grid_error(SheetFindings& found);

}  // namespace tenter::jobs
