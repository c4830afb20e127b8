// SPDX-License-Identifier: GPL-3.0-or-later
// The job that fits a cloth model to captures of a deforming sheet. Its options are in
// sheet_options.h, its result.json in common/report/sheet/README.md; residuals.h5 is beside it.
//
// Stages that an earlier attempt finished are taken from input.checkpoints; the bytes are those of
// a run that was never interrupted.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/capture.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

/// `captures` are those of the job, read, each with a sheet. As run_job otherwise.
Expected<void> run_sheet_fit(const JobInput& input, const nlohmann::json& spec,
                             std::vector<std::pair<std::string, capture::Capture>> captures,
                             const std::function<void(const JobProgress&)>& report,
                             const std::stop_token& stop);

}  // namespace tenter::jobs
