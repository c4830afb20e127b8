// SPDX-License-Identifier: GPL-3.0-or-later
// A job that simulates a scene: its specification in, result.json and frames.h5 out.
//
// result.json has the schema "tenter.simulation" (README.md). A frame without an equilibrium ends
// the walk: the job succeeds with the frames before it, "completed" false and the reason, unless
// there is none, which is an error. Called by run_job.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <stop_token>

#include "common/base/error.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

Expected<void> run_scene(const JobInput& input, const nlohmann::json& spec,
                         const std::function<void(const JobProgress&)>& report,
                         const std::stop_token& stop);

}  // namespace tenter::jobs
