// SPDX-License-Identifier: GPL-3.0-or-later
// The scheduler's half of the queue. Every write of a worker is guarded by job, state and epoch.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "server/jobs/queue/queue.h"
#include "server/jobs/queue/queue_change.h"

namespace tenter::jobs {

// Users with queued jobs and room under their quota, the one who is next first.
std::vector<std::string> Queue::Change::users_by_fair_share() {
  struct Candidate {
    std::int64_t running;
    double use_s;
    std::string user;
  };
  std::vector<Candidate> candidates;
  Statement find = db().prepare(
      "SELECT q.user, (SELECT count(*) FROM jobs r WHERE r.state = 'running' AND r.user = q.user),"
      " coalesce(u.use_s, 0), coalesce(u.use_at_ms, 0)"
      " FROM (SELECT DISTINCT user FROM jobs WHERE state = 'queued') q LEFT JOIN users u ON u.name "
      "= q.user");
  while (find.step()) {
    const double hours =
        static_cast<double>(std::max<std::int64_t>(0, now_ms_ - find.integer(3))) / 3.6e6;
    Candidate candidate{find.integer(1), find.real(2) * std::exp2(-hours), find.text(0)};
    if (candidate.running < quota_of(candidate.user).max_running)
      candidates.push_back(std::move(candidate));
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.running, a.use_s, a.user) < std::tie(b.running, b.use_s, b.user);
  });
  std::vector<std::string> users;
  users.reserve(candidates.size());
  for (auto& candidate : candidates) users.push_back(std::move(candidate.user));
  return users;
}

std::optional<JobId> Queue::Change::next_ready() {
  Statement find = db().prepare(
      "SELECT id FROM jobs j WHERE state = 'queued' AND user = ?"
      " AND NOT EXISTS (SELECT 1 FROM job_dependencies d JOIN jobs n ON n.id = d.needs"
      "                 WHERE d.job = j.id AND n.state <> 'succeeded')"
      " AND NOT EXISTS (SELECT 1 FROM jobs t WHERE t.spec_sha256 = j.spec_sha256 AND t.state = "
      "'running')"
      " ORDER BY priority DESC, id LIMIT 1");
  for (const auto& user : users_by_fair_share()) {
    if (find.reset().bind(1, std::string_view(user)).step()) return find.integer(0);
  }
  return std::nullopt;
}

JobRecord Queue::Change::claimed(ClaimKey claim) {
  JobRecord found = job(claim.job);
  if (found.state != JobState::running || found.epoch != claim.epoch) {
    refuse(ErrorKind::refused, "run " + std::to_string(claim.epoch) + " of job " +
                                   job_id_text(claim.job) + " is no longer wanted: the job is " +
                                   std::string(name_of(found.state)) + " in run " +
                                   std::to_string(found.epoch));
  }
  return found;
}

Expected<std::optional<JobRecord>> Queue::claim() {
  return as_expected([&]() -> Expected<std::optional<JobRecord>> {
    Change change(*this);
    while (const auto id = change.next_ready()) {
      JobRecord job = change.job(*id);
      if (const auto stored = change.find_stored(job.spec_sha256)) {
        change.settle(job, *stored, true);
        continue;
      }
      job.attempt += 1;
      job.epoch += 1;
      change.move(job, JobState::running, "started", "attempt " + std::to_string(job.attempt));
      const auto now = config_.clock.monotonic_ms();
      change.db()
          .prepare("UPDATE jobs SET lease_until_ms = ?, started_mono_ms = ? WHERE id = ?")
          .bind(1, now + config_.lease.count())
          .bind(2, now)
          .bind(3, job.id)
          .run();
      change.commit();
      return job;
    }
    change.commit();
    return std::nullopt;
  });
}

Expected<void> Queue::heartbeat(ClaimKey claim) {
  return as_expected([&]() -> Expected<void> {
    Change change(*this);
    change.claimed(claim);
    change.db()
        .prepare("UPDATE jobs SET lease_until_ms = ? WHERE id = ?")
        .bind(1, config_.clock.monotonic_ms() + config_.lease.count())
        .bind(2, claim.job)
        .run();
    change.commit();
    return {};
  });
}

Expected<void> Queue::complete(ClaimKey claim, const StoredResult& result) {
  return as_expected([&]() -> Expected<void> {
    Change change(*this);
    JobRecord job = change.claimed(claim);
    change.add_use(job);
    change.settle(job, result, false);
    change.commit();
    return {};
  });
}

Expected<void> Queue::fail(ClaimKey claim, const Error& error) {
  return as_expected([&]() -> Expected<void> {
    Change change(*this);
    JobRecord job = change.claimed(claim);
    change.add_use(job);
    change.move(job, JobState::failed, "failed", error.message, error);
    change.fail_dependants(job);
    change.commit();
    return {};
  });
}

void Queue::Change::bury_worker(JobRecord& job, const std::string& how) {
  add_use(job);
  job.worker_deaths += 1;
  job.epoch += 1;
  if (job.worker_deaths < job.max_attempts) {
    move(job, JobState::queued, "requeued", how);
    return;
  }
  const std::string message = "in quarantine: its worker died " +
                              std::to_string(job.worker_deaths) +
                              (job.worker_deaths == 1 ? " time" : " times") + ", at last: " + how;
  move(job, JobState::failed, "failed", message, Error{ErrorKind::job_failed, message});
  fail_dependants(job);
}

Expected<void> Queue::worker_died(ClaimKey claim, const std::string& how) {
  return as_expected([&]() -> Expected<void> {
    Change change(*this);
    JobRecord job = change.claimed(claim);
    change.bury_worker(job, how);
    change.commit();
    return {};
  });
}

Expected<void> Queue::release(ClaimKey claim, const std::string& why) {
  return as_expected([&]() -> Expected<void> {
    Change change(*this);
    JobRecord job = change.claimed(claim);
    change.add_use(job);
    job.epoch += 1;
    change.move(job, JobState::queued, "requeued", why);
    change.commit();
    return {};
  });
}

Expected<std::vector<ClaimKey>> Queue::expire() {
  return as_expected([&]() -> Expected<std::vector<ClaimKey>> {
    const auto next = next_expiry_ms();
    if (!next) return tl::unexpected(next.error());
    if (!*next || **next > config_.clock.monotonic_ms()) return std::vector<ClaimKey>{};
    Change change(*this);
    std::vector<ClaimKey> expired;
    Statement find = change.db().prepare(
        "SELECT id, epoch FROM jobs WHERE state = 'running' AND lease_until_ms <= ?");
    for (find.bind(1, config_.clock.monotonic_ms()); find.step();) {
      expired.push_back({find.integer(0), find.integer(1)});
    }
    for (const auto& claim : expired) {
      JobRecord job = change.job(claim.job);
      change.bury_worker(
          job, "its worker was silent for " + std::to_string(config_.lease.count()) + " ms");
    }
    change.commit();
    return expired;
  });
}

Expected<std::optional<std::int64_t>> Queue::next_expiry_ms() const {
  return as_expected([&]() -> Expected<std::optional<std::int64_t>> {
    const std::lock_guard lock(read_mutex_);
    Statement find =
        reader_->prepare("SELECT min(lease_until_ms) FROM jobs WHERE state = 'running'");
    find.step();
    if (find.is_null(0)) return std::nullopt;
    return find.integer(0);
  });
}

}  // namespace tenter::jobs
