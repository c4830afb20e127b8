// SPDX-License-Identifier: GPL-3.0-or-later
// The durable queue: jobs, captures, requests and users in one SQLite file. What a function
// returned is on disk.
//
//   queued --claim--> running --complete--> succeeded          any number of claims, each with a
//   larger epoch;
//      ^                 |----fail--------> failed             whoever writes for an older epoch is
//      refused |                 |----worker_died-> queued, or failed (quarantine) after
//      max_attempts deaths
//      +--retry-- failed, cancelled <--cancel-- queued, running
//
// Claims are leases on the monotonic clock: a change of the wall clock or a suspended machine
// expires none, and a new daemon re-queues whatever was running (recover, inside open). Every
// change of a job's row adds one event whose number is the row's revision. One writing and one
// reading connection, so readers do not wait for a commit's fsync. Any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/spec.h"
#include "server/jobs/types.h"

namespace tenter::jobs {

class Database;

struct Clock {
  std::function<std::int64_t()> wall_ms;
  std::function<std::int64_t()>
      monotonic_ms;  ///< of this boot; stands still while the machine sleeps
  static Clock system();
};

struct QueueConfig {
  std::filesystem::path file;
  std::string engine;  ///< names the worker program; results of another engine are not reused
  Quota default_quota;
  double default_time_limit_s = 3600;
  double max_time_limit_s = 7 * 24 * 3600.0;
  std::uint64_t default_memory_limit_bytes = 4ull << 30;
  std::uint64_t max_memory_limit_bytes = 64ull << 30;
  int max_attempts = 3;
  int max_retries = 10;
  std::chrono::milliseconds lease{30000};
  Clock clock = Clock::system();
  /// Is this result file in the store and sound? Asked before a stored result answers a job.
  std::function<bool(const std::string& sha256)> result_is_sound;
};

struct StoredResult {
  std::string result_sha256;
  std::uint64_t result_bytes = 0;
  std::string residuals_sha256;  ///< "": the job left none
  std::uint64_t residuals_bytes = 0;
  std::string frames_sha256 = {};  ///< the same
  std::uint64_t frames_bytes = 0;
};

/// One run of one job.
struct ClaimKey {
  JobId job = 0;
  std::int64_t epoch = 0;
  bool operator==(const ClaimKey&) const = default;
  bool operator<(const ClaimKey& other) const {
    return job != other.job ? job < other.job : epoch < other.epoch;
  }
};

class Queue {
 public:
  /// Opens, repairs, re-queues what a previous daemon was running.
  static Expected<std::unique_ptr<Queue>> open(QueueConfig config);
  ~Queue();

  const std::vector<std::string>& findings() const { return findings_; }
  std::int64_t server_epoch() const { return server_epoch_; }
  const std::string& server_id() const { return server_id_; }

  // --- for users (queue.cpp)
  Expected<Submitted> submit(const SubmitRequest& request, const JobSpec& spec);
  Expected<JobPage> list(const JobFilter& filter) const;
  Expected<JobRecord> show(JobId job) const;
  Expected<std::vector<JobEvent>> events(JobId job, std::int64_t after_number, int limit) const;
  Expected<JobRecord> cancel(const std::string& user, JobId job);
  Expected<JobRecord> retry(const std::string& user, const std::string& request_id, JobId job);

  // --- for the scheduler (queue_claims.cpp)
  /// The next job by fair share: of the users who have a job ready and are below their quota, the
  /// one with the fewest running, then the least recent use; of this user's jobs the highest
  /// priority, then the oldest. Jobs whose result is in the store succeed on the way. A job whose
  /// twin is running waits for it.
  Expected<std::optional<JobRecord>> claim();
  /// Extends the lease; refused when the claim is no longer this one.
  Expected<void> heartbeat(ClaimKey claim);
  Expected<void> complete(ClaimKey claim, const StoredResult& result);
  Expected<void> fail(ClaimKey claim, const Error& error);
  /// The worker crashed or fell silent: back to the queue, or failed for good after max_attempts
  /// deaths.
  Expected<void> worker_died(ClaimKey claim, const std::string& how);
  /// Back to the queue through no fault of the job (the daemon stops).
  Expected<void> release(ClaimKey claim, const std::string& why);
  /// Treats every claim whose lease has passed as died; returns them so that their workers can be
  /// killed.
  Expected<std::vector<ClaimKey>> expire();
  /// When the first lease passes, on the monotonic clock; none when nothing runs.
  Expected<std::optional<std::int64_t>> next_expiry_ms() const;

  // --- captures and users (queue_catalogue.cpp)
  struct CaptureAdded {
    CaptureRecord capture;
    bool created = false;
  };
  /// `transfer`: the upload that brought it; committed_transfer() tells its end to who asks again.
  Expected<CaptureAdded> add_capture(CaptureRecord capture, const std::string& transfer = "");
  Expected<std::optional<std::string>> committed_transfer(const std::string& transfer) const;
  Expected<CapturePage> captures(const CaptureFilter& filter) const;
  Expected<CaptureRecord> capture(const std::string& sha256) const;
  Expected<StoredResult> stored_result(JobId job) const;
  Expected<Usage> usage(const std::string& user) const;
  Expected<void> set_quota(const std::string& user, const Quota& quota);
  Expected<QueueNumbers> numbers() const;
  /// Calls with every object that a row names, and its size; reports what is wrong with one
  /// sentence per object.
  Expected<std::vector<std::string>> check_objects(
      const std::function<Expected<void>(const std::string& sha256, std::uint64_t size)>& check)
      const;

  /// Events committed since the last call, in the order of commits.
  std::vector<JobEvent> take_events();

 private:
  class Change;  // a transaction under the writer's lock, with the events it makes
  explicit Queue(QueueConfig config);
  Expected<void> repair_rows();
  Expected<void> recover();
  void prune_requests(Change& change);

  QueueConfig config_;
  std::vector<std::string> findings_;
  std::int64_t server_epoch_ = 0;
  std::string server_id_;

  mutable std::mutex write_mutex_;
  std::unique_ptr<Database> writer_;
  std::int64_t last_prune_ms_ = 0;
  mutable std::mutex read_mutex_;
  std::unique_ptr<Database> reader_;
  std::mutex events_mutex_;
  std::vector<JobEvent> events_;
};

bool is_user_name(std::string_view name);

}  // namespace tenter::jobs
