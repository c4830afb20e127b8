// SPDX-License-Identifier: GPL-3.0-or-later
// The worker process around one call of a job function: reads its order, limits itself, reports,
// ends with a code.
//
//   int main(int argc, char** argv) { return tenter::jobs::worker_main(argc, argv,
//   tenter::jobs::run_job); }
//
// It dies with its daemon, turns SIGTERM into the stop token, limits its memory, writes a heartbeat
// from a thread of its own, and lets progress through at most ten times a second (a change of stage
// always).
#pragma once

#include <functional>
#include <stop_token>

#include "common/base/error.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

using JobFunction = std::function<Expected<void>(
    const JobInput&, const std::function<void(const JobProgress&)>&, std::stop_token)>;

/// Usage: PROGRAM ORDER_FILE, with a pipe as descriptor 3. Returns the exit code.
int worker_main(int argc, char** argv, const JobFunction& run);

}  // namespace tenter::jobs
