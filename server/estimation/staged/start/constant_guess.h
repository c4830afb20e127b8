// SPDX-License-Identifier: GPL-3.0-or-later
// Where a staged fit begins: curves with one control point, and their constant stiffnesses from the
// equation gap on all that was measured.
//
//   auto record = guess_all(model, {"first_guess", terms, ties, sequences}, options);
//
// Pure; one thread.
#pragma once

#include "server/estimation/staged/stage.h"

namespace tenter::estimation {

/// A guess for `before`, not at zero where it was not: without any stiffness a curve can hide that
/// it is needed, and frames may have no rest.
double started(double guess, double before, const model::Parameter& p);

/// Splines that have no range yet, and those of `terms`, with one control point.
void begin_with_one_point(model::Model& model, const std::vector<std::string>& terms);

/// Constant stiffnesses of all terms together by the equation gap on all that was measured,
/// written into `model`; no frame is solved. A record without `done` says why there is none.
Expected<StageRecord> guess_all(model::Model& model, const StageTask& task,
                                const StageOptions& options);

}  // namespace tenter::estimation
