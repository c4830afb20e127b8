// SPDX-License-Identifier: GPL-3.0-or-later
// A worker as a child process: how it is started, and what its end means. Inside
// local_executor.cpp.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <filesystem>
#include <optional>

#include "common/base/error.h"
#include "server/jobs/worker/executor.h"

namespace tenter::jobs {

/// What is known of a worker besides its exit status.
struct WorkerEnd {
  std::optional<Error> said;  ///< its own error line
  bool asked_to_stop = false;
  bool out_of_time = false;
};

/// Starts `program` with order.folder/order.json in a process group of its own; `pipe_end` becomes
/// its descriptor 3 and must be above 3. Nothing else of the caller's stays open in it.
Expected<pid_t> spawn_worker(const std::filesystem::path& program, const WorkOrder& order,
                             int pipe_end);

/// `status` and `used` are wait4's.
Outcome outcome_of(const WorkOrder& order, const WorkerEnd& end, int status, const rusage& used);

}  // namespace tenter::jobs
