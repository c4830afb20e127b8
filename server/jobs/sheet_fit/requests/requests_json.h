// SPDX-License-Identifier: GPL-3.0-or-later
// What requests found, as keys of result.json ("starts", "convexity", "samples", "limit"; each null
// where it was not asked for) and as lines of its checklist. common/report/sheet/README.md lists
// their content.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

/// Adds the keys.
void put_requests(const SheetFindings& found, nlohmann::json& document);

/// Appends the lines.
void put_request_checks(const SheetFindings& found, nlohmann::json& checklist);

}  // namespace tenter::jobs
