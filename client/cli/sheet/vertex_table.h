// SPDX-License-Identifier: Apache-2.0
// What `tenter residuals --vertices` prints: one row per frame and vertex, as table, CSV or JSON.
//
// Positions in m (the table: residuals in mm); a coordinate that was not measured is blank in CSV
// and null in JSON.
#pragma once

#include <string>
#include <vector>

#include "client/cli/output.h"
#include "common/report/sheet/vertex_residuals.h"

namespace tenter::cli {

std::string vertex_text(const std::vector<report::VertexResiduals>& blocks);
std::string vertex_csv(const std::vector<report::VertexResiduals>& blocks);
/// {"job_id", "vertices": [{"capture", "title", "rows": [...]}]}
Json vertex_json(const std::vector<report::VertexResiduals>& blocks, const std::string& job_id);

}  // namespace tenter::cli
