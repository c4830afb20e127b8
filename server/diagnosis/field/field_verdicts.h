// SPDX-License-Identifier: GPL-3.0-or-later
// From the findings of sheets to verdicts in words (design, step 9), with the numbers that speak
// for them, and the checklist.
#pragma once

#include "server/diagnosis/field/diagnose_sheet.h"

namespace tenter::diagnosis {

/// Of findings, fits and scores that are done.
void pass_sheet_verdicts(SheetDiagnosis& d, const SheetRequest& request, const Control& control);

}  // namespace tenter::diagnosis
