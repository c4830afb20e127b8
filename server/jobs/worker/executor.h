// SPDX-License-Identifier: GPL-3.0-or-later
// Where workers run. The scheduler starts claimed jobs, hears what they report and stops them;
// whether a worker is a process here (local_executor.h) or elsewhere is this interface's secret.
//
// An executor never touches the queue: that a report comes from a claim which is no longer wanted
// is decided there, by its epoch.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/queue/queue.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

/// One run of one job, complete: the worker asks nothing back.
struct WorkOrder {
  ClaimKey claim;
  std::string spec_json;
  std::vector<std::pair<std::string, std::filesystem::path>> captures;
  std::filesystem::path folder;       ///< of this run alone; the result files go to folder/out
  std::filesystem::path checkpoints;  ///< of the work, outlives the run; see JobInput
  std::filesystem::path log;          ///< standard output and error are appended here
  double time_limit_s = 0;
  std::uint64_t memory_limit_bytes = 0;
  std::chrono::milliseconds heartbeat{10000};
};

enum class Ending {
  finished,       ///< the result files are in folder/out
  failed,         ///< run_job returned an Error
  crashed,        ///< ended by a signal or an unknown exit code
  out_of_memory,  ///< hit its memory limit
  out_of_time,    ///< hit its time limit and was killed
  cancelled       ///< stopped because stop() asked for it
};

struct Outcome {
  Ending ending = Ending::crashed;
  Error error;  ///< one sentence, unless finished
};

/// What a worker said or did since the last poll. Its latest progress stands for all before.
struct WorkReport {
  ClaimKey claim;
  std::optional<JobProgress> progress;
  std::optional<Outcome> outcome;  ///< the last report of this claim
};

class Executor {
 public:
  enum class Manner { ask, kill };

  virtual ~Executor() = default;
  /// Returns once the worker runs. The calling thread must live as long as the worker.
  virtual Expected<void> start(const WorkOrder& order) = 0;
  /// `ask` first, and kill after a grace; unknown claims are ignored.
  virtual void stop(ClaimKey claim, Manner manner) = 0;
  /// Never waits. A claim with a report is alive.
  virtual std::vector<WorkReport> poll() = 0;
  virtual int slots() const = 0;
  /// Workers that still occupy a slot.
  virtual int busy() const = 0;
};

}  // namespace tenter::jobs
