// SPDX-License-Identifier: GPL-3.0-or-later
// The thread that brings jobs from the queue to workers and their results into the store.
//
// One pass: hear the workers, settle what has ended, expire silent claims, claim while slots are
// free, tell the listener; then sleep until somebody wakes it or the next lease passes. With
// nothing running it sleeps for ever. What cannot be written (a full disk) is kept and tried again
// every second.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/queue/queue.h"
#include "server/jobs/store/checkpoints.h"
#include "server/jobs/store/store.h"
#include "server/jobs/worker/executor.h"

namespace tenter::jobs {

struct SchedulerConfig {
  std::filesystem::path work;  ///< one folder per run, removed when settled
  std::filesystem::path logs;
  Checkpoints checkpoints;
  std::chrono::milliseconds heartbeat{10000};
  std::function<void(const std::string&)> log;
};

class Scheduler {
 public:
  Scheduler(Queue& queue, Store& store, SchedulerConfig config);
  ~Scheduler();  ///< as stop()

  void set_listener(std::function<void(const JobEvent&)> listener) {
    listener_ = std::move(listener);
  }
  /// `executor` must outlive stop(); wake() is its way to say that poll() has something.
  void start(Executor& executor);
  /// Kills the workers and gives their jobs back to the queue.
  void stop();
  /// Something changed: a new job, an event, a report. Any thread.
  void wake();
  /// The row is cancelled already; this stops its worker, if it has one.
  void cancel(JobId job);
  /// The latest that a running job's worker said.
  std::optional<JobProgress> progress(JobId job) const;

  std::filesystem::path log_file(JobId job) const;

 private:
  struct Live {
    std::optional<JobProgress> progress;
    std::int64_t renewed_ms = 0;  // lease written, monotonic
    JobEvent last;                // of its start, the frame of progress events
    std::string spec_sha256;
  };
  struct Settlement {
    ClaimKey claim;
    std::function<Expected<void>()> write;
    bool succeeded = false;
  };

  void run();
  void hear(const std::vector<WorkReport>& reports);
  void hear_progress(const WorkReport& report);
  Expected<StoredResult> ingest(const ClaimKey& claim);
  void settle(ClaimKey claim, const Outcome& outcome);
  void write_settlements();
  void expire();
  void fill_slots();
  Expected<WorkOrder> order_for(const JobRecord& job);
  void tell();
  std::optional<std::chrono::milliseconds> sleep_time();
  std::filesystem::path folder_of(ClaimKey claim) const;
  void forget(ClaimKey claim);
  /// A work that ended: its checkpoints are of no more use, or are kept for the next attempt.
  void tidy_checkpoints(ClaimKey claim, bool succeeded);
  void trouble(const std::string& doing, const Error& error);

  Queue& queue_;
  Store& store_;
  const SchedulerConfig config_;
  Checkpoints checkpoints_;
  const Clock clock_ = Clock::system();
  std::function<void(const JobEvent&)> listener_;
  Executor* executor_ = nullptr;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool woken_ = false, stopping_ = false;  // by mutex_
  std::map<ClaimKey, Live> live_;          // by mutex_

  // of the thread alone
  std::vector<Settlement> unsettled_;
  std::vector<JobEvent> progress_events_;
  bool try_again_ = false;
  std::string last_trouble_;

  std::thread thread_;
};

}  // namespace tenter::jobs
