// SPDX-License-Identifier: GPL-3.0-or-later
// What the queue knows besides jobs: captures, users, results, numbers.
#include <cmath>

#include "common/base/sha256.h"
#include "server/jobs/queue/queue.h"
#include "server/jobs/queue/queue_change.h"

namespace tenter::jobs {
namespace {

const std::string kCaptureColumns =
    "sha256, title, kind, user, created_ms, size_bytes, iif(json_valid(summary_json), "
    "summary_json, '{}')";
// a damaged id is skipped; start-up has told of it
const std::string kSoundCapture = "length(sha256) = 64 AND sha256 NOT GLOB '*[^0-9a-f]*'";

CaptureRecord capture_from_row(const Statement& row) {
  return {row.text(0), row.text(1),    row.text(2),
          row.text(3), row.integer(4), static_cast<std::uint64_t>(row.integer(5)),
          row.text(6)};
}

std::optional<CaptureRecord> find_capture(const Database& db, const std::string& sha256) {
  Statement find = db.prepare("SELECT " + kCaptureColumns + " FROM captures WHERE sha256 = ?");
  find.bind(1, std::string_view(sha256));
  if (!find.step()) return std::nullopt;
  return capture_from_row(find);
}

}  // namespace

Expected<Queue::CaptureAdded> Queue::add_capture(CaptureRecord capture,
                                                 const std::string& transfer) {
  return as_expected([&]() -> Expected<CaptureAdded> {
    if (!is_sha256(capture.sha256)) return bad_input("'" + capture.sha256 + "' is not a SHA-256");
    if (!is_user_name(capture.user))
      return bad_input("'" + capture.user.substr(0, 80) + "' is not a user name");
    Change change(*this);
    if (!transfer.empty()) {
      change.db()
          .prepare("INSERT OR REPLACE INTO requests VALUES('', ?, 'upload', '', ?, ?)")
          .bind(1, std::string_view(transfer))
          .bind(2, std::string_view(capture.sha256))
          .bind(3, change.now_ms())
          .run();
    }
    if (auto known = find_capture(change.db(), capture.sha256)) {
      change.commit();
      return CaptureAdded{*std::move(known), false};
    }
    capture.created_ms = change.now_ms();
    change.db()
        .prepare(
            "INSERT INTO captures(sha256, title, kind, user, created_ms, size_bytes, summary_json)"
            " VALUES(?,?,?,?,?,?,?)")
        .bind(1, std::string_view(capture.sha256))
        .bind(2, std::string_view(capture.title))
        .bind(3, std::string_view(capture.kind))
        .bind(4, std::string_view(capture.user))
        .bind(5, capture.created_ms)
        .bind(6, static_cast<std::int64_t>(capture.size_bytes))
        .bind(7, std::string_view(capture.summary_json))
        .run();
    change.commit();
    return CaptureAdded{std::move(capture), true};
  });
}

Expected<std::optional<std::string>> Queue::committed_transfer(const std::string& transfer) const {
  return as_expected([&]() -> Expected<std::optional<std::string>> {
    const std::lock_guard lock(read_mutex_);
    Statement find = reader_->prepare(
        "SELECT reply FROM requests WHERE user = '' AND request_id = ? AND operation = 'upload'");
    if (!find.bind(1, std::string_view(transfer)).step()) return std::nullopt;
    return find.text(0);
  });
}

Expected<CapturePage> Queue::captures(const CaptureFilter& filter) const {
  return as_expected([&]() -> Expected<CapturePage> {
    if (filter.limit < 1 || filter.limit > 1000) {
      return bad_input("limit " + std::to_string(filter.limit) + " is not between 1 and 1000");
    }
    const std::string where = " FROM captures WHERE " + kSoundCapture +
                              " AND (?1 = '' OR user = ?1) AND (?2 = '' OR kind = ?2)";
    const std::lock_guard lock(read_mutex_);
    CapturePage page;
    Statement count = reader_->prepare("SELECT count(*)" + where);
    count.bind(1, std::string_view(filter.user)).bind(2, std::string_view(filter.kind)).step();
    page.total = count.integer(0);
    Statement find = reader_->prepare("SELECT " + kCaptureColumns + where +
                                      " ORDER BY number DESC LIMIT ?3 OFFSET ?4");
    find.bind(1, std::string_view(filter.user))
        .bind(2, std::string_view(filter.kind))
        .bind(3, std::int64_t{filter.limit})
        .bind(4, filter.offset);
    while (find.step()) page.captures.push_back(capture_from_row(find));
    return page;
  });
}

Expected<CaptureRecord> Queue::capture(const std::string& sha256) const {
  return as_expected([&]() -> Expected<CaptureRecord> {
    const std::lock_guard lock(read_mutex_);
    auto found = find_capture(*reader_, sha256);
    if (!found)
      return tenter::fail(ErrorKind::not_found, "there is no capture " + sha256.substr(0, 80));
    return *std::move(found);
  });
}

Expected<StoredResult> Queue::stored_result(JobId job) const {
  return as_expected([&]() -> Expected<StoredResult> {
    const std::lock_guard lock(read_mutex_);
    Statement find = reader_->prepare(
        "SELECT state, result_sha256, result_bytes, residuals_sha256, residuals_bytes, "
        "frames_sha256, frames_bytes FROM jobs WHERE id = ?");
    find.bind(1, job);
    if (!find.step())
      return tenter::fail(ErrorKind::not_found, "there is no job " + job_id_text(job));
    if (find.text(0) != "succeeded") {
      return tenter::fail(ErrorKind::refused,
                          "job " + job_id_text(job) + " is " + find.text(0) + " and has no result");
    }
    return StoredResult{find.text(1), static_cast<std::uint64_t>(find.integer(2)),
                        find.text(3), static_cast<std::uint64_t>(find.integer(4)),
                        find.text(5), static_cast<std::uint64_t>(find.integer(6))};
  });
}

Expected<Usage> Queue::usage(const std::string& user) const {
  return as_expected([&]() -> Expected<Usage> {
    const std::lock_guard lock(read_mutex_);
    Usage usage{user, config_.default_quota, 0, 0, 0, 0};
    Statement find = reader_->prepare(
        "SELECT (SELECT count(*) FROM jobs WHERE state = 'queued' AND user = ?1),"
        " (SELECT count(*) FROM jobs WHERE state = 'running' AND user = ?1),"
        " (SELECT coalesce(sum(size_bytes), 0) FROM captures WHERE user = ?1),"
        " (SELECT coalesce(sum(result_bytes + residuals_bytes + frames_bytes), 0) FROM jobs"
        "  WHERE user = ?1 AND state = 'succeeded' AND from_store = 0)");
    find.bind(1, std::string_view(user)).step();
    usage.queued = static_cast<int>(find.integer(0));
    usage.running = static_cast<int>(find.integer(1));
    usage.stored_bytes = static_cast<std::uint64_t>(find.integer(2) + find.integer(3));
    Statement row = reader_->prepare(
        "SELECT max_queued, max_running, max_stored_bytes, use_s, use_at_ms FROM users WHERE name "
        "= ?");
    if (row.bind(1, std::string_view(user)).step()) {
      if (!row.is_null(0)) usage.quota.max_queued = static_cast<int>(row.integer(0));
      if (!row.is_null(1)) usage.quota.max_running = static_cast<int>(row.integer(1));
      if (!row.is_null(2))
        usage.quota.max_stored_bytes = static_cast<std::uint64_t>(row.integer(2));
      const auto age = std::max<std::int64_t>(0, config_.clock.wall_ms() - row.integer(4));
      usage.recent_use_s = row.real(3) * std::exp2(-static_cast<double>(age) / 3.6e6);
    }
    return usage;
  });
}

Expected<void> Queue::set_quota(const std::string& user, const Quota& quota) {
  return as_expected([&]() -> Expected<void> {
    if (!is_user_name(user)) return bad_input("'" + user.substr(0, 80) + "' is not a user name");
    if (quota.max_queued < 0 || quota.max_running < 0)
      return bad_input("a quota cannot be negative");
    Change change(*this);
    change.db()
        .prepare(
            "INSERT INTO users(name, max_queued, max_running, max_stored_bytes) VALUES(?1, ?2, ?3, "
            "?4)"
            " ON CONFLICT(name) DO UPDATE SET max_queued = ?2, max_running = ?3, max_stored_bytes "
            "= ?4")
        .bind(1, std::string_view(user))
        .bind(2, std::int64_t{quota.max_queued})
        .bind(3, std::int64_t{quota.max_running})
        .bind(4, static_cast<std::int64_t>(quota.max_stored_bytes))
        .run();
    change.commit();
    return {};
  });
}

Expected<QueueNumbers> Queue::numbers() const {
  return as_expected([&]() -> Expected<QueueNumbers> {
    const std::lock_guard lock(read_mutex_);
    QueueNumbers numbers;
    Statement states = reader_->prepare("SELECT state, count(*) FROM jobs GROUP BY state");
    while (states.step()) {
      const auto count = states.integer(1);
      switch (job_state_from(states.text(0)).value_or(JobState::failed)) {
        case JobState::queued:
          numbers.queued += count;
          break;
        case JobState::running:
          numbers.running += count;
          break;
        case JobState::succeeded:
          numbers.succeeded += count;
          break;
        case JobState::failed:
          numbers.failed += count;
          break;
        case JobState::cancelled:
          numbers.cancelled += count;
          break;
      }
    }
    Statement captures = reader_->prepare(
        "SELECT count(*), coalesce(sum(size_bytes), 0) FROM captures WHERE " + kSoundCapture);
    captures.step();
    numbers.captures = captures.integer(0);
    numbers.capture_bytes = static_cast<std::uint64_t>(captures.integer(1));
    return numbers;
  });
}

Expected<std::vector<std::string>> Queue::check_objects(
    const std::function<Expected<void>(const std::string&, std::uint64_t)>& check) const {
  return as_expected([&]() -> Expected<std::vector<std::string>> {
    const std::lock_guard lock(read_mutex_);
    std::vector<std::string> troubles;
    Statement captures =
        reader_->prepare("SELECT sha256, size_bytes, title FROM captures WHERE " + kSoundCapture);
    while (captures.step()) {
      if (auto sound = check(captures.text(0), static_cast<std::uint64_t>(captures.integer(1)));
          !sound) {
        troubles.push_back("capture '" + captures.text(2) + "': " + sound.error().message);
      }
    }
    Statement results = reader_->prepare(
        "SELECT id, result_sha256, result_bytes, residuals_sha256, residuals_bytes,"
        " frames_sha256, frames_bytes FROM jobs WHERE state = 'succeeded' AND from_store = 0");
    while (results.step()) {
      for (const int column : {1, 3, 5}) {
        if (column > 1 && results.text(column).empty()) continue;
        const auto size = static_cast<std::uint64_t>(results.integer(column + 1));
        if (auto sound = check(results.text(column), size); !sound) {
          troubles.push_back("result of job " + job_id_text(results.integer(0)) + ": " +
                             sound.error().message);
        }
      }
    }
    return troubles;
  });
}

}  // namespace tenter::jobs
