// SPDX-License-Identifier: GPL-3.0-or-later
// Inside the queue: one transaction on its rows, with the steps that several operations share. Not
// for other folders.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/jobs/queue/queue.h"
#include "server/jobs/queue/sqlite.h"

namespace tenter::jobs {

/// Columns of `jobs` in the order in which job_from_row reads them.
extern const std::string kJobColumns;
JobRecord job_from_row(const Statement& row);
/// Without dependencies, captures and specification.
std::optional<JobRecord> find_job(const Database& db, JobId job);
/// Fills depends_on and captures; with `spec`, spec_json.
class JobDetails {
 public:
  explicit JobDetails(const Database& db);
  void fill(JobRecord& job, bool spec);

 private:
  Statement dependencies_, captures_, spec_;
};

class Queue::Change {
 public:
  explicit Change(Queue& queue);
  Database& db() { return *queue_.writer_; }
  std::int64_t now_ms() const { return now_ms_; }
  const QueueConfig& config() const { return queue_.config_; }

  JobRecord job(JobId id);  ///< with details; throws DatabaseError of kind not_found
  /// Moves the row to `state`, adds the event.
  void move(JobRecord& job, JobState state, const std::string& what, const std::string& message,
            const std::optional<Error>& error = std::nullopt);
  /// A failed or cancelled job takes along the jobs that wait for it.
  void fail_dependants(const JobRecord& job);
  /// Succeeded with these bytes.
  void settle(JobRecord& job, const StoredResult& result, bool from_store);
  /// A sound result of the same specification by the same engine.
  std::optional<StoredResult> find_stored(const std::string& spec_sha256);
  /// Dependencies that have not succeeded.
  std::int64_t open_dependencies(JobId job);
  void add_use(const JobRecord& job);
  std::vector<std::string> users_by_fair_share();
  /// The job that is to run next, if any may.
  std::optional<JobId> next_ready();
  /// The running job of this claim; throws DatabaseError of kind refused when it is another's.
  JobRecord claimed(ClaimKey claim);
  /// Requeued, or in quarantine after too many deaths.
  void bury_worker(JobRecord& job, const std::string& how);
  Quota quota_of(const std::string& user);
  std::int64_t count(const std::string& user, JobState state);

  /// The reply stored for this request, if it was made before. Refuses an id that was used for
  /// something else.
  std::optional<std::string> recall(const std::string& user, const std::string& request_id,
                                    const std::string& operation, const std::string& digest);
  void remember(const std::string& user, const std::string& request_id,
                const std::string& operation, const std::string& digest, const std::string& reply);

  void commit();

 private:
  Queue& queue_;
  std::lock_guard<std::mutex> lock_;
  Transaction transaction_;
  std::int64_t now_ms_;
  std::vector<JobEvent> events_;
};

[[noreturn]] inline void refuse(ErrorKind kind, std::string message) {
  throw DatabaseError{{kind, std::move(message)}};
}

}  // namespace tenter::jobs
