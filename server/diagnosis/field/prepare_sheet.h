// SPDX-License-Identifier: GPL-3.0-or-later
// From captured sheets to what the chain compares with: a start from the equation gap, frames
// without rest left out by name, noise, the baseline fit, what the sheets excite.
#pragma once

#include "server/diagnosis/field/diagnose_sheet.h"

namespace tenter::diagnosis {

/// Fills data, held_out, noise, dropped, baseline and excitation.
Expected<SheetDiagnosis> prepare_sheets(const SheetRequest& request, const Control& control);

FieldFitOptions field_options(const Control& control);

}  // namespace tenter::diagnosis
