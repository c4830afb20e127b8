// SPDX-License-Identifier: GPL-3.0-or-later
// What the queue remembers: jobs, captures, events, quotas. Plain values, copied out of the
// database.
//
// Times for people are wall clock, milliseconds since 1970 UTC; nothing is decided by them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

/// Grows, never reused. On the wire it is its decimal text.
using JobId = std::int64_t;
std::string job_id_text(JobId id);
Expected<JobId> parse_job_id(std::string_view text);

enum class JobState { queued, running, succeeded, failed, cancelled };
std::string_view name_of(JobState state);
std::optional<JobState> job_state_from(std::string_view name);
inline bool is_final(JobState state) {
  return state != JobState::queued && state != JobState::running;
}

std::string_view name_of(ErrorKind kind);
std::optional<ErrorKind> error_kind_from(std::string_view name);

/// What a user asks for. Priority, limits and dependencies do not change the result, so they are
/// not in the specification.
struct SubmitRequest {
  std::string user = {};
  std::string request_id =
      {};  ///< made by the client, 1..128 characters; a repeat gets the same job
  std::string spec_json = {};  ///< schema "tenter.job"
  int priority = 0;            ///< -100..100, higher first among the jobs of one user
  std::vector<JobId> depends_on = {};
  std::optional<double> time_limit_s = std::nullopt;
  std::optional<std::uint64_t> memory_limit_bytes = std::nullopt;
  std::optional<int> max_attempts =
      std::nullopt;  ///< worker deaths after which the job is put into quarantine
};

struct JobRecord {
  JobId id = 0;
  std::string kind;  ///< "fit", "simulate", "diagnose"
  std::string user;
  int priority = 0;
  JobState state = JobState::queued;
  std::int64_t revision = 0;  ///< grows with every change of the row; the number of its last event
  int attempt = 0;            ///< starts so far; 1 in the first run
  int worker_deaths = 0;      ///< starts that ended by a crash or by silence
  int max_attempts = 0;
  int retries = 0;         ///< asked for by the user
  std::int64_t epoch = 0;  ///< of the current claim
  std::int64_t created_ms = 0;
  std::int64_t started_ms = 0;  ///< 0: not yet; of the current attempt
  std::int64_t ended_ms = 0;    ///< 0: not yet
  double time_limit_s = 0;
  std::uint64_t memory_limit_bytes = 0;
  std::optional<Error> error;  ///< why it failed or was cancelled
  std::string message;         ///< of the last event
  bool from_store = false;     ///< the result was there before the job
  std::string spec_sha256;
  std::string result_sha256;     ///< of result.json, when succeeded
  std::string residuals_sha256;  ///< of residuals.h5, when succeeded and written
  std::string frames_sha256;     ///< of frames.h5, the same
  std::vector<JobId> depends_on;
  std::vector<std::string> captures;
  std::string spec_json;                ///< filled by show only
  std::optional<JobProgress> progress;  ///< running: the latest that the worker said
};

struct Submitted {
  JobRecord job;
  bool repeated = false;  ///< this request_id had been accepted before
};

struct JobFilter {
  std::string user = {};  ///< "": everybody's
  std::optional<JobState> state = std::nullopt;
  std::string kind = {};     ///< "": all
  std::string capture = {};  ///< "": all; else jobs that use this capture
  JobId before = 0;          ///< 0: from the newest; else jobs older than this one
  int limit = 100;           ///< 1..1000
};

struct JobPage {
  std::vector<JobRecord> jobs;  ///< newest first, without spec_json
  std::int64_t total = 0;       ///< that match the filter, on all pages
  JobId next_before = 0;        ///< `before` of the next page, 0: this was the last
};

/// One change of a job's row. `number` counts from 1 without gaps per job and equals the row's
/// revision.
struct JobEvent {
  JobId job = 0;
  std::int64_t number = 0;
  std::string what;  ///< submitted, started, succeeded, failed, cancelled, retried, requeued;
                     ///< progress (not kept)
  std::string message;
  JobState state = JobState::queued;
  int attempt = 0;
  std::int64_t epoch = 0;
  std::int64_t time_ms = 0;
  std::string user;
  std::optional<JobProgress>
      progress;  ///< with what == "progress"; number is then the revision it belongs to
};

struct CaptureRecord {
  std::string sha256;
  std::string title;
  std::string kind;
  std::string user;
  std::int64_t created_ms = 0;
  std::uint64_t size_bytes = 0;
  std::string summary_json;  ///< one object: what the reader found in it
};

struct CaptureFilter {
  std::string user = {};
  std::string kind = {};
  std::int64_t offset = 0;
  int limit = 100;  ///< 1..1000
};

struct CapturePage {
  std::vector<CaptureRecord> captures;  ///< newest first
  std::int64_t total = 0;
};

struct Quota {
  int max_queued = 2000;
  int max_running = 64;
  std::uint64_t max_stored_bytes = 50ull << 30;
};

struct Usage {
  std::string user;
  Quota quota;
  int queued = 0;
  int running = 0;
  std::uint64_t stored_bytes = 0;
  double recent_use_s = 0;  ///< worker seconds, halved every hour
};

struct QueueNumbers {
  std::int64_t queued = 0, running = 0, succeeded = 0, failed = 0, cancelled = 0;
  std::int64_t captures = 0;
  std::uint64_t capture_bytes = 0;
};

}  // namespace tenter::jobs
