// SPDX-License-Identifier: GPL-3.0-or-later
// The job "diagnose" on captures of a deforming sheet: what the model gets wrong, why, and what
// would be right (server/diagnosis/field).
//
// Options are those of a diagnosis ("seed", "null_twins", "max_effects", "leave_out") and those of
// a sheet's fit that say how captures are read ("resolution", "grid", "points", "frames", "roles",
// "held_out", "sigma_m", "sigma_N": noise of captures that state none, which is estimated where
// these are absent; "without_grid_error": the grid's own error is looked at before any material is
// blamed, unless it is false or cells are equal).
//
// Writes result.json and residuals.h5 into the job's folder.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/capture.h"
#include "server/diagnosis/findings.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

/// bad_input: options, or captures that cannot be fitted; cancelled.
Expected<void> run_sheet_diagnosis(const JobInput& input, const nlohmann::json& spec,
                                   const diagnosis::Options& options,
                                   std::vector<std::pair<std::string, capture::Capture>> captures,
                                   const std::function<void(const JobProgress&)>& report,
                                   const std::stop_token& stop);

/// Whether an option is one of a diagnosis, and no sheet's.
bool is_diagnosis_option(const std::string& key);

}  // namespace tenter::jobs
