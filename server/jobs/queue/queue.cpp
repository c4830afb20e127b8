// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/queue/queue.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "common/base/sha256.h"
#include "server/jobs/queue/queue_change.h"
#include "server/jobs/queue/schema.h"

namespace tenter::jobs {
namespace {

constexpr std::uint64_t kLeastMemory = 64u << 20;
constexpr int kMaxPage = 1000;
constexpr std::size_t kMaxDependencies = 64;
constexpr std::int64_t kKeepRequestsMs = 24 * 3600 * 1000;
constexpr std::int64_t kKeepRequestsCount = 10000;  // whatever the clock says

void check_request(const SubmitRequest& request, const QueueConfig& config) {
  const auto bad = [](const std::string& message) { refuse(ErrorKind::bad_input, message); };
  if (request.priority < -100 || request.priority > 100) {
    bad("priority " + std::to_string(request.priority) + " is not between -100 and 100");
  }
  if (request.depends_on.size() > kMaxDependencies) {
    bad("a job can wait for at most " + std::to_string(kMaxDependencies) + " others");
  }
  const double time = request.time_limit_s.value_or(config.default_time_limit_s);
  if (!(time > 0) || time > config.max_time_limit_s) {
    bad("the time limit of " + std::to_string(time) + " s is not above 0 and at most " +
        std::to_string(config.max_time_limit_s) + " s");
  }
  const auto memory = request.memory_limit_bytes.value_or(config.default_memory_limit_bytes);
  if (memory < kLeastMemory || memory > config.max_memory_limit_bytes) {
    bad("the memory limit of " + std::to_string(memory) + " bytes is not between " +
        std::to_string(kLeastMemory) + " and " + std::to_string(config.max_memory_limit_bytes));
  }
  const int attempts = request.max_attempts.value_or(config.max_attempts);
  if (attempts < 1 || attempts > 10) {
    bad("max_attempts is " + std::to_string(attempts) + ", not between 1 and 10");
  }
}

}  // namespace

Clock Clock::system() {
  return {[] {
            return std::chrono::duration_cast<std::chrono::milliseconds>(
                       std::chrono::system_clock::now().time_since_epoch())
                .count();
          },
          [] {
            timespec now{};
            ::clock_gettime(CLOCK_MONOTONIC, &now);
            return std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
          }};
}

bool is_user_name(std::string_view name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  });
}

Queue::Queue(QueueConfig config) : config_(std::move(config)) {}
Queue::~Queue() = default;

Expected<std::unique_ptr<Queue>> Queue::open(QueueConfig config) {
  return as_expected([&]() -> Expected<std::unique_ptr<Queue>> {
    std::unique_ptr<Queue> queue(new Queue(std::move(config)));
    auto db = open_queue_database(queue->config_.file, queue->findings_);
    if (!db) return tl::unexpected(db.error());
    queue->writer_ = std::move(*db);
    {
      Change change(*queue);
      change.db().execute(
          "INSERT OR IGNORE INTO meta VALUES('server_id', lower(hex(randomblob(16)))), "
          "('server_epoch', '0');"
          "UPDATE meta SET value = CAST(value AS INTEGER) + 1 WHERE key = 'server_epoch'");
      Statement find = change.db().prepare(
          "SELECT (SELECT value FROM meta WHERE key = 'server_id'),"
          " (SELECT value FROM meta WHERE key = 'server_epoch')");
      find.step();
      queue->server_id_ = find.text(0);
      queue->server_epoch_ = find.integer(1);
      find.reset();
      queue->prune_requests(change);
      change.commit();
    }
    if (auto done = queue->repair_rows(); !done) return tl::unexpected(done.error());
    if (auto done = queue->recover(); !done) return tl::unexpected(done.error());
    queue->reader_ = std::make_unique<Database>(queue->config_.file, Database::Mode::read_only);
    return queue;
  });
}

void Queue::prune_requests(Change& change) {
  last_prune_ms_ = config_.clock.monotonic_ms();
  change.db()
      .prepare(
          "DELETE FROM requests WHERE time_ms < ? AND rowid <= (SELECT coalesce(max(rowid), 0) "
          "FROM requests) - ?")
      .bind(1, change.now_ms() - kKeepRequestsMs)
      .bind(2, kKeepRequestsCount)
      .run();
}

// A row that breaks a rule must not stop the queue: it is failed, and told.
Expected<void> Queue::repair_rows() {
  return as_expected([&]() -> Expected<void> {
    Change change(*this);
    std::set<JobId> damaged;
    Statement states = change.db().prepare(
        "SELECT id FROM jobs WHERE state NOT IN ('queued', 'running', 'succeeded', 'failed', "
        "'cancelled')");
    while (states.step()) damaged.insert(states.integer(0));
    Statement specs = change.db().prepare(
        "SELECT j.id, j.spec_sha256, s.json FROM jobs j LEFT JOIN specs s ON s.sha256 = "
        "j.spec_sha256"
        " WHERE j.state IN ('queued', 'running')");
    while (specs.step()) {
      if (sha256_hex(specs.text(2)) != specs.text(1)) damaged.insert(specs.integer(0));
    }
    for (const JobId id : damaged) {
      JobRecord job = change.job(id);
      const std::string message = "the job's row in the database was damaged";
      job.epoch += 1;
      // events of a damaged row may have gone on beyond its revision
      Statement last =
          change.db().prepare("SELECT coalesce(max(number), 0) FROM job_events WHERE job = ?");
      last.bind(1, id).step();
      job.revision = std::max(job.revision, last.integer(0));
      change.move(job, JobState::failed, "failed", message, Error{ErrorKind::internal, message});
      change.fail_dependants(job);
      findings_.push_back("job " + job_id_text(id) + ": its row was damaged, it was failed");
    }
    Statement captures = change.db().prepare("SELECT number, sha256 FROM captures");
    while (captures.step()) {
      if (!is_sha256(captures.text(1))) {
        findings_.push_back("capture row " + std::to_string(captures.integer(0)) +
                            ": its id is damaged, it is skipped");
      }
    }
    change.commit();
    return {};
  });
}

Expected<void> Queue::recover() {
  return as_expected([&]() -> Expected<void> {
    Change change(*this);
    std::vector<JobId> running;
    Statement find = change.db().prepare("SELECT id FROM jobs WHERE state = 'running' ORDER BY id");
    while (find.step()) running.push_back(find.integer(0));
    for (const JobId id : running) {
      JobRecord job = change.job(id);
      job.epoch += 1;
      change.move(job, JobState::queued, "requeued", "the daemon was restarted while it ran");
    }
    change.commit();
    return {};
  });
}

Expected<Submitted> Queue::submit(const SubmitRequest& request, const JobSpec& spec) {
  return as_expected([&]() -> Expected<Submitted> {
    Change change(*this);
    if (auto reply = change.recall(request.user, request.request_id, "submit", spec.sha256)) {
      return Submitted{change.job(std::stoll(*reply)), true};
    }
    check_request(request, config_);
    const Quota quota = change.quota_of(request.user);
    if (change.count(request.user, JobState::queued) >= quota.max_queued) {
      refuse(ErrorKind::refused, "user " + request.user + " has " +
                                     std::to_string(quota.max_queued) +
                                     " jobs queued, as many as allowed");
    }
    Statement find_capture = change.db().prepare("SELECT 1 FROM captures WHERE sha256 = ?");
    for (const auto& capture : spec.captures) {
      if (!find_capture.reset().bind(1, std::string_view(capture)).step()) {
        refuse(ErrorKind::not_found, "capture " + capture + " is not in the store");
      }
    }
    const std::set<JobId> needs(request.depends_on.begin(), request.depends_on.end());
    for (const JobId id : needs) {
      const auto needed = find_job(change.db(), id);
      if (!needed)
        refuse(ErrorKind::not_found, "there is no job " + job_id_text(id) + " to wait for");
      if (is_final(needed->state) && needed->state != JobState::succeeded) {
        refuse(ErrorKind::refused, "job " + job_id_text(id) + ", which it should wait for, is " +
                                       std::string(name_of(needed->state)));
      }
    }

    change.db()
        .prepare("INSERT OR IGNORE INTO specs VALUES(?,?)")
        .bind(1, std::string_view(spec.sha256))
        .bind(2, std::string_view(spec.canonical))
        .run();
    change.db()
        .prepare(
            "INSERT INTO jobs(kind, user, priority, state, revision, max_attempts, created_ms, "
            "time_limit_s,"
            " memory_limit_bytes, spec_sha256) VALUES(?,?,?,'queued',0,?,?,?,?,?)")
        .bind(1, std::string_view(spec.kind))
        .bind(2, std::string_view(request.user))
        .bind(3, std::int64_t{request.priority})
        .bind(4, std::int64_t{request.max_attempts.value_or(config_.max_attempts)})
        .bind(5, change.now_ms())
        .bind(6, request.time_limit_s.value_or(config_.default_time_limit_s))
        .bind(7, static_cast<std::int64_t>(
                     request.memory_limit_bytes.value_or(config_.default_memory_limit_bytes)))
        .bind(8, std::string_view(spec.sha256))
        .run();
    const JobId id = change.db().last_row_id();
    Statement add_capture = change.db().prepare("INSERT INTO job_captures VALUES(?,?,?)");
    for (std::size_t i = 0; i < spec.captures.size(); ++i) {
      add_capture.reset()
          .bind(1, id)
          .bind(2, static_cast<std::int64_t>(i))
          .bind(3, std::string_view(spec.captures[i]))
          .run();
    }
    Statement add_need = change.db().prepare("INSERT INTO job_dependencies VALUES(?,?)");
    for (const JobId need : needs) add_need.reset().bind(1, id).bind(2, need).run();
    change.remember(request.user, request.request_id, "submit", spec.sha256, job_id_text(id));

    JobRecord job = change.job(id);
    change.move(job, JobState::queued, "submitted", "");
    if (change.open_dependencies(id) == 0) {
      if (const auto stored = change.find_stored(spec.sha256)) change.settle(job, *stored, true);
    }
    if (config_.clock.monotonic_ms() - last_prune_ms_ > 3600 * 1000) prune_requests(change);
    change.commit();
    return Submitted{std::move(job), false};
  });
}

Expected<JobPage> Queue::list(const JobFilter& filter) const {
  return as_expected([&]() -> Expected<JobPage> {
    if (filter.limit < 1 || filter.limit > kMaxPage) {
      return bad_input("limit " + std::to_string(filter.limit) + " is not between 1 and 1000");
    }
    std::string where = " WHERE 1";
    std::vector<std::string> values;
    const auto require = [&](const std::string& condition, std::string_view value) {
      if (value.empty()) return;
      where += " AND " + condition;
      values.emplace_back(value);
    };
    require("user = ?", filter.user);
    require("state = ?", filter.state ? name_of(*filter.state) : std::string_view());
    require("kind = ?", filter.kind);
    require("id IN (SELECT job FROM job_captures WHERE sha256 = ?)", filter.capture);
    const auto bind = [&](Statement& statement) {
      int place = 1;
      for (const auto& value : values) statement.bind(place++, std::string_view(value));
      return place;
    };

    const std::lock_guard lock(read_mutex_);
    JobPage page;
    Statement count = reader_->prepare("SELECT count(*) FROM jobs" + where);
    bind(count);
    count.step();
    page.total = count.integer(0);
    Statement find =
        reader_->prepare("SELECT " + kJobColumns + " FROM jobs" + where +
                         (filter.before > 0 ? " AND id < ?" : "") + " ORDER BY id DESC LIMIT ?");
    int place = bind(find);
    if (filter.before > 0) find.bind(place++, filter.before);
    find.bind(place, std::int64_t{filter.limit} + 1);
    JobDetails details(*reader_);
    while (find.step()) {
      if (static_cast<int>(page.jobs.size()) == filter.limit) {
        page.next_before = page.jobs.back().id;
        break;
      }
      page.jobs.push_back(job_from_row(find));
      details.fill(page.jobs.back(), false);
    }
    return page;
  });
}

Expected<JobRecord> Queue::show(JobId id) const {
  return as_expected([&]() -> Expected<JobRecord> {
    const std::lock_guard lock(read_mutex_);
    auto job = find_job(*reader_, id);
    if (!job) return tenter::fail(ErrorKind::not_found, "there is no job " + job_id_text(id));
    JobDetails(*reader_).fill(*job, true);
    return *std::move(job);
  });
}

Expected<std::vector<JobEvent>> Queue::events(JobId id, std::int64_t after_number,
                                              int limit) const {
  return as_expected([&]() -> Expected<std::vector<JobEvent>> {
    if (limit < 1 || limit > kMaxPage) {
      return bad_input("limit " + std::to_string(limit) + " is not between 1 and 1000");
    }
    const std::lock_guard lock(read_mutex_);
    const auto job = find_job(*reader_, id);
    if (!job) return tenter::fail(ErrorKind::not_found, "there is no job " + job_id_text(id));
    std::vector<JobEvent> found;
    Statement find = reader_->prepare(
        "SELECT number, what, message, state, attempt, epoch, time_ms FROM job_events WHERE job = "
        "? AND number > ?"
        " ORDER BY number LIMIT ?");
    for (find.bind(1, id).bind(2, after_number).bind(3, std::int64_t{limit}); find.step();) {
      found.push_back({id,
                       find.integer(0),
                       find.text(1),
                       find.text(2),
                       job_state_from(find.text(3)).value_or(JobState::failed),
                       static_cast<int>(find.integer(4)),
                       find.integer(5),
                       find.integer(6),
                       job->user,
                       {}});
    }
    return found;
  });
}

Expected<JobRecord> Queue::cancel(const std::string& user, JobId id) {
  return as_expected([&]() -> Expected<JobRecord> {
    Change change(*this);
    JobRecord job = change.job(id);
    if (job.user != user)
      refuse(ErrorKind::refused, "job " + job_id_text(id) + " belongs to user " + job.user);
    if (job.state == JobState::cancelled) return job;
    if (is_final(job.state)) {
      refuse(ErrorKind::refused,
             "job " + job_id_text(id) + " has already " + std::string(name_of(job.state)));
    }
    if (job.state == JobState::running) change.add_use(job);
    job.epoch += 1;
    const std::string message = "cancelled by " + user;
    change.move(job, JobState::cancelled, "cancelled", message,
                Error{ErrorKind::cancelled, message});
    change.fail_dependants(job);
    change.commit();
    return job;
  });
}

Expected<JobRecord> Queue::retry(const std::string& user, const std::string& request_id, JobId id) {
  return as_expected([&]() -> Expected<JobRecord> {
    Change change(*this);
    if (change.recall(user, request_id, "retry", job_id_text(id))) return change.job(id);
    JobRecord job = change.job(id);
    if (job.user != user)
      refuse(ErrorKind::refused, "job " + job_id_text(id) + " belongs to user " + job.user);
    if (job.state != JobState::failed && job.state != JobState::cancelled) {
      refuse(ErrorKind::refused, "job " + job_id_text(id) + " is " +
                                     std::string(name_of(job.state)) +
                                     "; only a failed or cancelled job can be run again");
    }
    if (job.retries >= config_.max_retries) {
      refuse(ErrorKind::refused, "job " + job_id_text(id) + " was run again " +
                                     std::to_string(job.retries) + " times, as often as allowed");
    }
    for (const JobId need : job.depends_on) {
      const auto needed = find_job(change.db(), need);
      if (needed && is_final(needed->state) && needed->state != JobState::succeeded) {
        refuse(ErrorKind::refused, "job " + job_id_text(need) + ", which it waits for, is " +
                                       std::string(name_of(needed->state)) +
                                       "; run that one again first");
      }
    }
    const Quota quota = change.quota_of(user);
    if (change.count(user, JobState::queued) >= quota.max_queued) {
      refuse(ErrorKind::refused, "user " + user + " has " + std::to_string(quota.max_queued) +
                                     " jobs queued, as many as allowed");
    }
    job.retries += 1;
    job.worker_deaths = 0;
    job.epoch += 1;
    change.move(job, JobState::queued, "retried", "run again by " + user);
    change.remember(user, request_id, "retry", job_id_text(id), job_id_text(id));
    change.commit();
    return job;
  });
}

std::vector<JobEvent> Queue::take_events() {
  const std::lock_guard lock(events_mutex_);
  return std::exchange(events_, {});
}

}  // namespace tenter::jobs
