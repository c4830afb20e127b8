// SPDX-License-Identifier: GPL-3.0-or-later
// The findings of a sheet's fit as result.json: schema "tenter.sheet_fit", whose keys
// common/report/sheet/README.md lists. No time, host or count of threads.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

nlohmann::json sheet_document(const SheetFindings& found);

}  // namespace tenter::jobs
