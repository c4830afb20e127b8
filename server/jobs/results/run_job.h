// SPDX-License-Identifier: GPL-3.0-or-later
// The seam between the queue and the science: one job's specification and captures in, result files
// out.
//
// Called by the worker process, once. The same input gives the same bytes, whatever the machine's
// load, the number of workers or the attempt.
#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"

namespace tenter::jobs {

struct JobInput {
  std::string spec_json;  ///< canonical, schema "tenter.job"; see README.md
  std::vector<std::pair<std::string, std::filesystem::path>> captures;  ///< SHA-256 -> file
  std::filesystem::path staging;  ///< existing empty folder for the result files
  /// Of this work alone, for what a later attempt need not do again; "" where there is no such
  /// place. It need not exist yet; what is in it was written by this program, maybe killed in the
  /// middle.
  std::filesystem::path checkpoints;
};

struct JobProgress {
  std::string stage;    ///< "read", "screen", "refit", ...
  std::string detail;   ///< within the stage: a term, a capture
  int iteration = 0;    ///< of the solver, in this stage
  double cost = 0;      ///< the solver's
  double fraction = 0;  ///< 0..1 of the whole job
};

/// Writes staging/result.json, and staging/residuals.h5 or, for a scene, staging/frames.h5. Same
/// input, same bytes. May call `report` from any thread, as often as it likes; returns
/// ErrorKind::cancelled soon after `stop` is requested.
Expected<void> run_job(const JobInput& input, const std::function<void(const JobProgress&)>& report,
                       const std::stop_token& stop);

}  // namespace tenter::jobs
