// SPDX-License-Identifier: GPL-3.0-or-later
// A job of kind "fit" with options.protocol, a test of internal friction, from captures to
// result.json and residuals.h5 as any other fit leaves them, with one more key: friction_test
// (friction_document.h).
//
//   hanging-weights     one capture of homogeneous strain whose x stretch was measured (a length)
//                       and whose x stress is the weight; its x axis lies along weft or warp
//   loops               captures of load-unload loops of one strain (both: points/run_point_test.h)
//   spiral, cantilever  captures of strips (strips/run_strip_test.h)
//
// The model of the specification is not used: a protocol has its own. Same input, same bytes.
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
