// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/queue/queue_change.h"

#include <algorithm>
#include <cmath>

namespace tenter::jobs {

const std::string kJobColumns =
    "id, kind, user, priority, state, revision, attempt, worker_deaths, max_attempts, retries, "
    "epoch,"
    " created_ms, started_ms, ended_ms, time_limit_s, memory_limit_bytes, error_kind, message,"
    " from_store, spec_sha256, result_sha256, residuals_sha256, frames_sha256";

JobRecord job_from_row(const Statement& row) {
  JobRecord job;
  int c = 0;
  job.id = row.integer(c++);
  job.kind = row.text(c++);
  job.user = row.text(c++);
  job.priority = static_cast<int>(row.integer(c++));
  const auto state = job_state_from(row.text(c++));
  job.revision = row.integer(c++);
  job.attempt = static_cast<int>(row.integer(c++));
  job.worker_deaths = static_cast<int>(row.integer(c++));
  job.max_attempts = static_cast<int>(row.integer(c++));
  job.retries = static_cast<int>(row.integer(c++));
  job.epoch = row.integer(c++);
  job.created_ms = row.integer(c++);
  job.started_ms = row.integer(c++);
  job.ended_ms = row.integer(c++);
  job.time_limit_s = row.real(c++);
  job.memory_limit_bytes = static_cast<std::uint64_t>(row.integer(c++));
  const auto error = error_kind_from(row.text(c++));
  job.message = row.text(c++);
  job.from_store = row.integer(c++) != 0;
  job.spec_sha256 = row.text(c++);
  job.result_sha256 = row.text(c++);
  job.residuals_sha256 = row.text(c++);
  job.frames_sha256 = row.text(c++);
  if (error) job.error = Error{*error, job.message};
  job.state = state.value_or(JobState::failed);
  if (!state) job.error = Error{ErrorKind::internal, "the job's row in the database is damaged"};
  return job;
}

std::optional<JobRecord> find_job(const Database& db, JobId job) {
  Statement find = db.prepare("SELECT " + kJobColumns + " FROM jobs WHERE id = ?");
  find.bind(1, job);
  if (!find.step()) return std::nullopt;
  return job_from_row(find);
}

JobDetails::JobDetails(const Database& db)
    : dependencies_(db.prepare("SELECT needs FROM job_dependencies WHERE job = ? ORDER BY needs")),
      captures_(db.prepare("SELECT sha256 FROM job_captures WHERE job = ? ORDER BY place")),
      spec_(db.prepare("SELECT json FROM specs WHERE sha256 = ?")) {}

void JobDetails::fill(JobRecord& job, bool spec) {
  for (dependencies_.reset().bind(1, job.id); dependencies_.step();) {
    job.depends_on.push_back(dependencies_.integer(0));
  }
  for (captures_.reset().bind(1, job.id); captures_.step();) {
    job.captures.push_back(captures_.text(0));
  }
  if (spec) {
    spec_.reset().bind(1, std::string_view(job.spec_sha256));
    if (spec_.step()) job.spec_json = spec_.text(0);
  }
}

Queue::Change::Change(Queue& queue)
    : queue_(queue),
      lock_(queue.write_mutex_),
      transaction_(*queue.writer_),
      now_ms_(queue.config_.clock.wall_ms()) {}

void Queue::Change::commit() {
  transaction_.commit();
  const std::lock_guard lock(queue_.events_mutex_);  // still under the writer's lock: in order
  for (auto& event : events_) queue_.events_.push_back(std::move(event));
  events_.clear();
}

JobRecord Queue::Change::job(JobId id) {
  auto found = find_job(db(), id);
  if (!found) refuse(ErrorKind::not_found, "there is no job " + job_id_text(id));
  JobDetails(db()).fill(*found, true);
  return *std::move(found);
}

void Queue::Change::move(JobRecord& job, JobState state, const std::string& what,
                         const std::string& message, const std::optional<Error>& error) {
  job.state = state;
  job.revision += 1;
  job.message = message;
  job.error = error;
  if (state == JobState::running) job.started_ms = now_ms_;
  job.ended_ms = is_final(state) ? now_ms_ : 0;
  db().prepare(
          "UPDATE jobs SET state=?, revision=?, attempt=?, worker_deaths=?, retries=?, epoch=?, "
          "started_ms=?,"
          " ended_ms=?, error_kind=?, message=?, from_store=? WHERE id=?")
      .bind(1, name_of(state))
      .bind(2, job.revision)
      .bind(3, std::int64_t{job.attempt})
      .bind(4, std::int64_t{job.worker_deaths})
      .bind(5, std::int64_t{job.retries})
      .bind(6, job.epoch)
      .bind(7, job.started_ms)
      .bind(8, job.ended_ms)
      .bind(9, error ? name_of(error->kind) : std::string_view())
      .bind(10, std::string_view(message))
      .bind(11, std::int64_t{job.from_store})
      .bind(12, job.id)
      .run();
  JobEvent event{job.id,      job.revision, what,    message,  state,
                 job.attempt, job.epoch,    now_ms_, job.user, {}};
  db().prepare("INSERT INTO job_events VALUES(?,?,?,?,?,?,?,?)")
      .bind(1, event.job)
      .bind(2, event.number)
      .bind(3, std::string_view(what))
      .bind(4, std::string_view(message))
      .bind(5, name_of(state))
      .bind(6, std::int64_t{event.attempt})
      .bind(7, event.epoch)
      .bind(8, event.time_ms)
      .run();
  events_.push_back(std::move(event));
}

void Queue::Change::fail_dependants(const JobRecord& ended) {
  std::vector<JobRecord> open{ended};
  while (!open.empty()) {
    const JobRecord cause = std::move(open.back());
    open.pop_back();
    std::vector<JobId> waiting;
    Statement find = db().prepare(
        "SELECT j.id FROM job_dependencies d JOIN jobs j ON j.id = d.job WHERE d.needs = ? AND "
        "j.state = 'queued'");
    for (find.bind(1, cause.id); find.step();) waiting.push_back(find.integer(0));
    for (const JobId id : waiting) {
      JobRecord dependant = job(id);
      const std::string message = "job " + job_id_text(cause.id) + ", which it waits for, " +
                                  (cause.state == JobState::cancelled ? "was cancelled" : "failed");
      dependant.epoch += 1;
      move(dependant, JobState::failed, "failed", message, Error{ErrorKind::job_failed, message});
      open.push_back(std::move(dependant));
    }
  }
}

void Queue::Change::settle(JobRecord& job, const StoredResult& result, bool from_store) {
  job.from_store = from_store;
  job.result_sha256 = result.result_sha256;
  job.residuals_sha256 = result.residuals_sha256;
  job.frames_sha256 = result.frames_sha256;
  db().prepare(
          "UPDATE jobs SET engine=?, result_sha256=?, result_bytes=?, residuals_sha256=?, "
          "residuals_bytes=?, frames_sha256=?, frames_bytes=? WHERE id=?")
      .bind(1, std::string_view(config().engine))
      .bind(2, std::string_view(result.result_sha256))
      .bind(3, static_cast<std::int64_t>(result.result_bytes))
      .bind(4, std::string_view(result.residuals_sha256))
      .bind(5, static_cast<std::int64_t>(result.residuals_bytes))
      .bind(6, std::string_view(result.frames_sha256))
      .bind(7, static_cast<std::int64_t>(result.frames_bytes))
      .bind(8, job.id)
      .run();
  move(job, JobState::succeeded, "succeeded", from_store ? "taken from the store" : "");
}

std::optional<StoredResult> Queue::Change::find_stored(const std::string& spec_sha256) {
  Statement find = db().prepare(
      "SELECT result_sha256, result_bytes, residuals_sha256, residuals_bytes, frames_sha256,"
      " frames_bytes FROM jobs WHERE spec_sha256=? AND state='succeeded' AND engine=? ORDER BY id "
      "LIMIT 1");
  find.bind(1, std::string_view(spec_sha256)).bind(2, std::string_view(config().engine));
  if (!find.step()) return std::nullopt;
  StoredResult result{find.text(0), static_cast<std::uint64_t>(find.integer(1)),
                      find.text(2), static_cast<std::uint64_t>(find.integer(3)),
                      find.text(4), static_cast<std::uint64_t>(find.integer(5))};
  const auto& sound = config().result_is_sound;
  for (const std::string& sha256 :
       {result.result_sha256, result.residuals_sha256, result.frames_sha256})
    if (sound && !sha256.empty() && !sound(sha256)) return std::nullopt;
  return result;
}

std::int64_t Queue::Change::open_dependencies(JobId job) {
  Statement find = db().prepare(
      "SELECT count(*) FROM job_dependencies d JOIN jobs j ON j.id = d.needs WHERE d.job = ? AND"
      " j.state <> 'succeeded'");
  find.bind(1, job).step();
  return find.integer(0);
}

// The half-life lets a user who was busy this morning start even after lunch.
void Queue::Change::add_use(const JobRecord& job) {
  Statement find = db().prepare("SELECT started_mono_ms FROM jobs WHERE id = ?");
  find.bind(1, job.id);
  if (!find.step()) return;
  const double seconds =
      std::max(0.0, 1e-3 * static_cast<double>(config().clock.monotonic_ms() - find.integer(0)));
  db().prepare(
          "INSERT INTO users(name, use_s, use_at_ms) VALUES(?1, ?2, ?3) ON CONFLICT(name) DO "
          "UPDATE SET"
          " use_s = use_s * pow(0.5, max(0, ?3 - use_at_ms) / 3600000.0) + ?2, use_at_ms = ?3")
      .bind(1, std::string_view(job.user))
      .bind(2, seconds)
      .bind(3, now_ms_)
      .run();
}

Quota Queue::Change::quota_of(const std::string& user) {
  Quota quota = config().default_quota;
  Statement find =
      db().prepare("SELECT max_queued, max_running, max_stored_bytes FROM users WHERE name = ?");
  find.bind(1, std::string_view(user));
  if (find.step()) {
    if (!find.is_null(0)) quota.max_queued = static_cast<int>(find.integer(0));
    if (!find.is_null(1)) quota.max_running = static_cast<int>(find.integer(1));
    if (!find.is_null(2)) quota.max_stored_bytes = static_cast<std::uint64_t>(find.integer(2));
  }
  return quota;
}

std::int64_t Queue::Change::count(const std::string& user, JobState state) {
  Statement find = db().prepare("SELECT count(*) FROM jobs WHERE state = ? AND user = ?");
  find.bind(1, name_of(state)).bind(2, std::string_view(user)).step();
  return find.integer(0);
}

std::optional<std::string> Queue::Change::recall(const std::string& user,
                                                 const std::string& request_id,
                                                 const std::string& operation,
                                                 const std::string& digest) {
  if (!is_user_name(user)) {
    refuse(ErrorKind::bad_input, "a user name has 1 to 64 letters, digits, '_', '-' or '.', not '" +
                                     user.substr(0, 80) + "'");
  }
  if (request_id.empty() || request_id.size() > 128) {
    refuse(ErrorKind::bad_input, "a request id has 1 to 128 characters");
  }
  Statement find = db().prepare(
      "SELECT operation, digest, reply FROM requests WHERE user = ? AND request_id = ?");
  find.bind(1, std::string_view(user)).bind(2, std::string_view(request_id));
  if (!find.step()) return std::nullopt;
  if (find.text(0) != operation || find.text(1) != digest) {
    refuse(ErrorKind::refused,
           "the request id '" + request_id + "' was used before for something else");
  }
  return find.text(2);
}

void Queue::Change::remember(const std::string& user, const std::string& request_id,
                             const std::string& operation, const std::string& digest,
                             const std::string& reply) {
  db().prepare("INSERT INTO requests VALUES(?,?,?,?,?,?)")
      .bind(1, std::string_view(user))
      .bind(2, std::string_view(request_id))
      .bind(3, std::string_view(operation))
      .bind(4, std::string_view(digest))
      .bind(5, std::string_view(reply))
      .bind(6, now_ms_)
      .run();
}

}  // namespace tenter::jobs
