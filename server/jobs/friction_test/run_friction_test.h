// SPDX-License-Identifier: GPL-3.0-or-later
// A job of kind "fit" with options.protocol = "hanging-weights": stiffness and internal friction
// from a capture of weights and lengths (server/estimation/friction_tests), as result.json and
// residuals.h5 of any other fit, with one more key:
//
//   friction_test: {protocol, direction, noise_m, gains_below, snapped,
//     numbers: [{name, unit, told, value | null, interval [lo | null, hi | null], words}],
//     stages: [{k1, k2, a, b, tau, rms_load_N_m}]}
//
// A number that the data do not tell is null there and among the parameters, and the checklist says
// what is known of it. The capture is one of homogeneous strain whose x stretch was measured (a
// length) and whose x stress is the weight; its x axis lies along weft or warp.
//
// The model of the specification is not used: the protocol has its own. Same input, same bytes.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <utility>

#include "common/capture/capture.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

Expected<void> run_friction_test(const JobInput& input, const nlohmann::json& spec,
                                 std::vector<std::pair<std::string, capture::Capture>> captures,
                                 const std::function<void(const JobProgress&)>& report,
                                 const std::stop_token& stop);

}  // namespace tenter::jobs
