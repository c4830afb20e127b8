// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a sheet's fit: loops of force over displacement, position errors over frames, and
// deformed meshes with their residuals; as common/report/sheet/README.md lists them.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

nlohmann::json sheet_figures(const SheetFindings& found);

/// Of each capture the frame that moved most and the one that is missed most.
nlohmann::json sheet_meshes(const SheetFindings& found);

}  // namespace tenter::jobs
