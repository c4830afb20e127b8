// SPDX-License-Identifier: GPL-3.0-or-later
// A diagnosis of sheets as result.json: schema "tenter.result", kind "diagnose", with the keys that
// common/report/README.md lists, and `meshes` and `structure` beside them. No time, host or count
// of threads.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "server/diagnosis/field/diagnose_sheet.h"
#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

/// `found`: captures, and both models' predictions of them.
nlohmann::json sheet_diagnosis_document(const diagnosis::SheetDiagnosis& d,
                                        const SheetFindings& found);

}  // namespace tenter::jobs
