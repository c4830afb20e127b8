// SPDX-License-Identifier: GPL-3.0-or-later
// A diagnosis (or a fit) as the documents that a job leaves: result.json, whose keys
// common/report/README.md lists, and the tables of residuals.h5. Neither holds a time, a host or a
// count of threads.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/report/residual_file.h"
#include "server/diagnosis/diagnose.h"

namespace tenter::jobs {

/// `kind` is that of the job: "fit", "simulate" or "diagnose".
nlohmann::json result_document(const diagnosis::Diagnosis& d, const diagnosis::Request& request,
                               const std::string& kind);

/// One table per capture and channel, every measured frame; weight 0 on readings that were left
/// out.
std::vector<report::ResidualTable> residual_tables(const diagnosis::Diagnosis& d);

}  // namespace tenter::jobs
