// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/queue/schema.h"

#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "server/jobs/store/files.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;

// One entry per version, never changed once released; a new need is a new entry.
constexpr const char* kMigrations[] = {
    R"sql(
CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE users(
  name TEXT PRIMARY KEY,
  max_queued INTEGER, max_running INTEGER, max_stored_bytes INTEGER,  -- NULL: the daemon's default
  use_s REAL NOT NULL DEFAULT 0,        -- worker seconds, halved every hour
  use_at_ms INTEGER NOT NULL DEFAULT 0  -- when use_s was right
) WITHOUT ROWID;
CREATE TABLE captures(
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  sha256 TEXT NOT NULL UNIQUE,
  title TEXT NOT NULL, kind TEXT NOT NULL, user TEXT NOT NULL,
  created_ms INTEGER NOT NULL, size_bytes INTEGER NOT NULL, summary_json TEXT NOT NULL);
CREATE INDEX captures_by_user ON captures(user);
CREATE TABLE specs(sha256 TEXT PRIMARY KEY, json TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE jobs(
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL, user TEXT NOT NULL, priority INTEGER NOT NULL,
  state TEXT NOT NULL, revision INTEGER NOT NULL,
  attempt INTEGER NOT NULL DEFAULT 0, worker_deaths INTEGER NOT NULL DEFAULT 0,
  max_attempts INTEGER NOT NULL, retries INTEGER NOT NULL DEFAULT 0,
  epoch INTEGER NOT NULL DEFAULT 0,
  lease_until_ms INTEGER NOT NULL DEFAULT 0,   -- monotonic clock of the daemon that claimed
  started_mono_ms INTEGER NOT NULL DEFAULT 0,  -- the same clock
  created_ms INTEGER NOT NULL, started_ms INTEGER NOT NULL DEFAULT 0, ended_ms INTEGER NOT NULL DEFAULT 0,
  time_limit_s REAL NOT NULL, memory_limit_bytes INTEGER NOT NULL,
  error_kind TEXT NOT NULL DEFAULT '', message TEXT NOT NULL DEFAULT '',
  from_store INTEGER NOT NULL DEFAULT 0,
  spec_sha256 TEXT NOT NULL,
  engine TEXT NOT NULL DEFAULT '',             -- the worker program that made the result
  result_sha256 TEXT NOT NULL DEFAULT '', result_bytes INTEGER NOT NULL DEFAULT 0,
  residuals_sha256 TEXT NOT NULL DEFAULT '', residuals_bytes INTEGER NOT NULL DEFAULT 0);
CREATE INDEX jobs_by_state ON jobs(state, user, priority DESC, id);
CREATE INDEX jobs_by_user ON jobs(user, id);
CREATE INDEX jobs_by_spec ON jobs(spec_sha256, state);
CREATE TABLE job_captures(job INTEGER NOT NULL, place INTEGER NOT NULL, sha256 TEXT NOT NULL,
  PRIMARY KEY(job, place)) WITHOUT ROWID;
CREATE INDEX job_captures_by_capture ON job_captures(sha256, job);
CREATE TABLE job_dependencies(job INTEGER NOT NULL, needs INTEGER NOT NULL,
  PRIMARY KEY(job, needs)) WITHOUT ROWID;
CREATE INDEX job_dependencies_by_need ON job_dependencies(needs, job);
CREATE TABLE job_events(
  job INTEGER NOT NULL, number INTEGER NOT NULL, what TEXT NOT NULL, message TEXT NOT NULL,
  state TEXT NOT NULL, attempt INTEGER NOT NULL, epoch INTEGER NOT NULL, time_ms INTEGER NOT NULL,
  PRIMARY KEY(job, number)) WITHOUT ROWID;
CREATE TABLE requests(
  user TEXT NOT NULL, request_id TEXT NOT NULL, operation TEXT NOT NULL, digest TEXT NOT NULL,
  reply TEXT NOT NULL, time_ms INTEGER NOT NULL,
  PRIMARY KEY(user, request_id));
CREATE INDEX requests_by_time ON requests(time_ms);
INSERT INTO meta VALUES('server_id', lower(hex(randomblob(16)))), ('server_epoch', '0');
)sql",
    // the frames of simulated scenes
    R"sql(
ALTER TABLE jobs ADD COLUMN frames_sha256 TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN frames_bytes INTEGER NOT NULL DEFAULT 0;
)sql",
};
constexpr int kNewest = static_cast<int>(std::size(kMigrations));

void migrate(Database& db, const fs::path& file) {
  db.execute(
      "CREATE TABLE IF NOT EXISTS migrations(version INTEGER PRIMARY KEY, applied TEXT NOT NULL)");
  Statement find = db.prepare("SELECT coalesce(max(version), 0) FROM migrations");
  find.step();
  const std::int64_t have = find.integer(0);
  find.reset();
  if (have > kNewest) {
    throw DatabaseError{{ErrorKind::refused, file.string() +
                                                 ": was written by a newer tenterd (schema " +
                                                 std::to_string(have) + ", this one knows " +
                                                 std::to_string(kNewest) + ")"}};
  }
  for (auto version = have + 1; version <= kNewest; ++version) {
    Transaction change(db);
    db.execute(kMigrations[version - 1]);
    db.prepare("INSERT INTO migrations VALUES(?, datetime('now'))").bind(1, version).run();
    change.commit();
  }
}

void check_pages(Database& db) {
  Statement check = db.prepare("PRAGMA quick_check(1)");
  if (!check.step() || check.text(0) != "ok") {
    throw DatabaseError{{ErrorKind::internal, "the job database is damaged: " + check.text(0)},
                        true};
  }
}

std::unique_ptr<Database> open_checked(const fs::path& file) {
  auto db = std::make_unique<Database>(file, Database::Mode::read_write);
  check_pages(*db);
  migrate(*db, file);
  return db;
}

// Walks one table from both ends, so that a bad page in the middle costs the rows of that page
// only.
std::int64_t copy_rows(const Database& from, const Database& to, const std::string& table) {
  std::int64_t copied = 0;
  for (const char* order : {"ASC", "DESC"}) {
    try {
      Statement rows = from.prepare("SELECT * FROM " + table + " ORDER BY 1 " + order);
      std::string names, places;
      for (int c = 0; c < rows.columns(); ++c) {
        names += (c ? "," : "") + rows.column_name(c);
        places += c ? ",?" : "?";
      }
      Statement insert =
          to.prepare("INSERT OR REPLACE INTO " + table + "(" + names + ") VALUES(" + places + ")");
      while (rows.step()) {
        for (int c = 0; c < rows.columns(); ++c) rows.copy_to(c, insert, c + 1);
        try {
          insert.run();
          if (*order == 'A') ++copied;
        } catch (const DatabaseError& trouble) {
          if (trouble.error.kind == ErrorKind::no_space) throw;  // else a row that breaks a rule
        }
        insert.reset();
      }
      return copied;  // the whole table was readable
    } catch (const DatabaseError& trouble) {
      if (trouble.error.kind == ErrorKind::no_space) throw;
    }
  }
  return copied;
}

void salvage(const fs::path& damaged, Database& fresh, std::vector<std::string>& findings) {
  static constexpr const char* kTables[] = {
      "meta",       "users",   "captures", "specs", "jobs", "job_captures", "job_dependencies",
      "job_events", "requests"};
  std::string told;
  try {
    const Database old(damaged, Database::Mode::read_write);
    Transaction all(fresh);
    for (const char* table : kTables) {
      const auto count = copy_rows(old, fresh, table);
      told += (told.empty() ? "" : ", ") + std::to_string(count) + " " + table;
    }
    all.commit();
    findings.push_back("the job database was damaged; rows saved from it: " + told);
  } catch (const DatabaseError& trouble) {
    findings.push_back("the job database was damaged and nothing could be read from it: " +
                       trouble.error.message);
  }
}

fs::path move_aside(const fs::path& file) {
  fs::path to;
  for (int n = 1;; ++n) {
    to = file;
    to += ".damaged-" + std::to_string(n);
    if (!fs::exists(to)) break;
  }
  for (const char* part : {"", "-wal", "-shm"}) {
    fs::path source = file, target = to;
    source += part;
    target += part;
    if (::rename(source.c_str(), target.c_str()) != 0 && errno != ENOENT) {
      throw DatabaseError{system_error(target, "setting the damaged job database aside", errno)};
    }
  }
  return to;
}

}  // namespace

Expected<std::unique_ptr<Database>> open_queue_database(const fs::path& file,
                                                        std::vector<std::string>& findings) {
  return as_expected([&]() -> Expected<std::unique_ptr<Database>> {
    try {
      return open_checked(file);
    } catch (const DatabaseError& trouble) {
      if (!trouble.damaged) throw;
    }
    const fs::path old = move_aside(file);
    findings.push_back(file.string() + ": is damaged and was moved to " + old.filename().string());
    auto fresh = open_checked(file);
    salvage(old, *fresh, findings);
    return fresh;
  });
}

}  // namespace tenter::jobs
