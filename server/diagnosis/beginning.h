// SPDX-License-Identifier: GPL-3.0-or-later
// What a diagnosis begins with: readings that are worth something, a baseline that stands, and
// frames that are fine enough. Effects that were found may change that, and then it begins anew.
#pragma once

#include <vector>

#include "server/diagnosis/backward.h"
#include "server/diagnosis/diagnose.h"

namespace tenter::diagnosis {

/// Noise, readings set aside and the fitted baseline.
Expected<Diagnosis> begin(const Request& request, const Control& control);

/// The same on a refined solve: from a better optimum it begins again, and where means over frames
/// move the residuals, with twice as many of them, as `request` then says.
Expected<Diagnosis> begin_refined(Request& request, const Control& control);

/// True where what was found changes what the data are worth: then what was weighed and judged has
/// to be done again, from the baseline on.
bool begin_anew(Diagnosis& d, const Reference& current, const std::vector<Accepted>& accepted,
                const Request& request);

/// Keeps as misread what the extended model does not reach either.
void confirm_outliers(Diagnosis& d);

}  // namespace tenter::diagnosis
