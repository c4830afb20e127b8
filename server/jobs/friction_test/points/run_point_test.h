// SPDX-License-Identifier: GPL-3.0-or-later
// Jobs of kind "fit" whose captures are of homogeneous strain (server/estimation/friction_tests):
//
//   hanging-weights  one capture of weights and lengths; options: {protocol}; a figure
//                    "weights": length against weight with the model
//   loops            captures of load-unload loops of one strain; options: {protocol, direction:
//                    weft | warp}. Its part has also {runs, runs_passed_over, readings,
//                    noise_is_from_fit, missed_share, lost_share, lost_share_of_model, rate:
//                    {answer, viscosity_share, evidence, fallen, hold_s, loss_ratio,
//                    rate_ratio, words}}
//
// Loops whose captures say that the load depends on the rate are refused with the evidence in words
// (rate_question.h): the job ends without a result. Where the captures cannot tell, the checklist
// says so.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/capture.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

Expected<void> run_hanging_weights(const JobInput& input, const nlohmann::json& spec,
                                   std::vector<std::pair<std::string, capture::Capture>> captures,
                                   const std::function<void(const JobProgress&)>& report,
                                   const std::stop_token& stop);

Expected<void> run_loops(const JobInput& input, const nlohmann::json& spec,
                         const std::vector<std::pair<std::string, capture::Capture>>& captures,
                         const std::function<void(const JobProgress&)>& report,
                         const std::stop_token& stop);

}  // namespace tenter::jobs
