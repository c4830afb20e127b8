// SPDX-License-Identifier: GPL-3.0-or-later
// Stiffness and friction of stretch from hanging weights (thesis 5.3.2, table 5.1).
//
// The papers' stages on errors of the force give the start (anchored_start.h), a fit of the lengths
// along the whole path the result (length_errors.h). One direction a table: green_u (weft) or
// green_v (warp). Where no noise of the lengths is given, it is that of the fit's own residuals.
//
//   Expected<FrictionEstimate> found = fit_hanging_weights(table, "green_v");
//   for (const FrictionNumber& n : found->numbers) print(n.name, n.is_told ? ... : n.words);
//
// bad_input: see check() of weight_table.h; a measure that is not a stretch. Cost: about 2 ms a fit
// of 130 readings, 100 of them with profiles. Pure; any thread.
#pragma once

#include <string_view>

#include "common/base/error.h"
#include "server/estimation/friction_tests/friction_estimate.h"
#include "server/estimation/friction_tests/stretch/weight_table.h"

namespace tenter::estimation {

Expected<FrictionEstimate> fit_hanging_weights(const WeightTable& table, std::string_view measure,
                                               const FrictionFitOptions& options = {});

}  // namespace tenter::estimation
