// SPDX-License-Identifier: GPL-3.0-or-later
// A job of kind "fit" with options.protocol = "spiral" or "cantilever": stiffness and internal
// friction of bending from profiles of strips (server/estimation/friction_tests/bending).
//
//   options: {protocol, samples: n of each profile, 1 to 40, 5 as in the papers}
//
// Positive and negative sense of curvature are fitted on their own, a part of friction_test each
// (../friction_document.h), with also {spirals, cantilevers, samples, left_out,
// cantilever: {k1, k2} | null, model}. The model of the result is that of the first part. Errors of
// the result are of the strain 3 kappa in place of a stress. residuals.h5 has a table a capture and
// part, a row a sample: run and frame of the strip, block the radius, displacement_m the place
// along it. A capture of cantilevers may be given beside spirals; spirals beside cantilevers are
// passed over, with a word.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/capture.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

Expected<void> run_strip_test(const JobInput& input, const nlohmann::json& spec,
                              const std::vector<std::pair<std::string, capture::Capture>>& captures,
                              const std::function<void(const JobProgress&)>& report,
                              const std::stop_token& stop);

}  // namespace tenter::jobs
