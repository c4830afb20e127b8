// SPDX-License-Identifier: GPL-3.0-or-later
// What a sheet's fit leaves, reading by reading: the content of residuals.h5.
#pragma once

#include <vector>

#include "common/report/residual_file.h"
#include "server/jobs/sheet_fit/sheet_findings.h"

namespace tenter::jobs {

/// One table per clip force, every frame. "Baseline" is the starting model, "extended" the fitted
/// one; frames without a rest predict nothing and have weight 0, as has all that was held out.
std::vector<report::ResidualTable> sheet_residual_tables(const SheetFindings& found);

/// One block per capture with points.
std::vector<report::VertexResiduals> sheet_vertex_residuals(const SheetFindings& found);

}  // namespace tenter::jobs
