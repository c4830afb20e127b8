// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/queue/sqlite.h"

#include <sqlite3.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace tenter::jobs {
namespace {

[[noreturn]] void raise(sqlite3* db, int code, std::string_view doing) {
  const int last_errno = errno;  // SQLite forgets it when a COMMIT fails
  const int primary = code & 0xff;
  const int system = db && sqlite3_system_errno(db) != 0 ? sqlite3_system_errno(db) : last_errno;
  const std::string reason = db ? sqlite3_errmsg(db) : sqlite3_errstr(code);
  const char* name = db ? sqlite3_db_filename(db, "main") : nullptr;
  const std::string file = name && *name ? name : "the job database";
  const bool full =
      primary == SQLITE_FULL ||
      (primary == SQLITE_IOERR && (system == ENOSPC || system == EDQUOT || system == EFBIG));
  if (full) {
    throw DatabaseError{{ErrorKind::no_space, file + ": the disk is full, nothing was changed"},
                        false};
  }
  std::string message = file + ": " + std::string(doing) + " failed: " + reason;
  if (primary == SQLITE_IOERR && system != 0)
    message += std::string(" (") + std::strerror(system) + ")";
  const bool busy = primary == SQLITE_BUSY || primary == SQLITE_LOCKED;
  throw DatabaseError{{busy ? ErrorKind::unavailable : ErrorKind::internal, message},
                      primary == SQLITE_CORRUPT || primary == SQLITE_NOTADB};
}

}  // namespace

Statement::Statement(sqlite3* db, std::string_view sql) : db_(db) {
  const int code =
      sqlite3_prepare_v2(db, sql.data(), static_cast<int>(sql.size()), &statement_, nullptr);
  if (code != SQLITE_OK) raise(db, code, "preparing a statement");
}

Statement::~Statement() {
  sqlite3_finalize(statement_);
}

Statement::Statement(Statement&& other) noexcept
    : db_(other.db_), statement_(std::exchange(other.statement_, nullptr)) {}

Statement& Statement::bind(int place, std::int64_t value) {
  if (int code = sqlite3_bind_int64(statement_, place, value)) raise(db_, code, "binding a number");
  return *this;
}

Statement& Statement::bind(int place, double value) {
  if (int code = sqlite3_bind_double(statement_, place, value))
    raise(db_, code, "binding a number");
  return *this;
}

Statement& Statement::bind(int place, std::string_view value) {
  const auto size = static_cast<sqlite3_uint64>(value.size());
  const char* data = value.data() ? value.data() : "";
  if (int code =
          sqlite3_bind_text64(statement_, place, data, size, SQLITE_TRANSIENT, SQLITE_UTF8)) {
    raise(db_, code, "binding a text");
  }
  return *this;
}

Statement& Statement::bind_null(int place) {
  if (int code = sqlite3_bind_null(statement_, place)) raise(db_, code, "binding nothing");
  return *this;
}

Statement& Statement::reset() {
  sqlite3_reset(statement_);  // repeats the error of the last step, which was already raised
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  raise(db_, code, sqlite3_stmt_readonly(statement_) ? "reading" : "writing");
}

int Statement::columns() const {
  return sqlite3_column_count(statement_);
}
bool Statement::is_null(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}
std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}
double Statement::real(int column) const {
  return sqlite3_column_double(statement_, column);
}
std::string Statement::column_name(int column) const {
  return sqlite3_column_name(statement_, column);
}

std::string Statement::text(int column) const {
  const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  if (!data) return {};
  return {data, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

void Statement::copy_to(int column, Statement& other, int place) const {
  if (int code =
          sqlite3_bind_value(other.statement_, place, sqlite3_column_value(statement_, column))) {
    raise(db_, code, "copying a value");
  }
}

Database::Database(const std::filesystem::path& file, Mode mode) {
  const int flags = (mode == Mode::read_write ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE
                                              : SQLITE_OPEN_READONLY) |
                    SQLITE_OPEN_NOMUTEX;
  const int code = sqlite3_open_v2(file.c_str(), &db_, flags, nullptr);
  try {
    if (code != SQLITE_OK) raise(db_, code, "opening");
    sqlite3_extended_result_codes(db_, 1);
    sqlite3_busy_timeout(db_, 10000);
    execute("PRAGMA foreign_keys=ON");
    if (mode == Mode::read_write) {
      execute(
          "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA journal_size_limit=16777216");
    }
  } catch (...) {
    sqlite3_close_v2(db_);
    throw;
  }
}

Database::~Database() {
  sqlite3_close_v2(db_);
}

void Database::execute(const std::string& sql) const {
  if (int code = sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr))
    raise(db_, code, "a change");
}

std::int64_t Database::last_row_id() const {
  return sqlite3_last_insert_rowid(db_);
}
std::int64_t Database::changes() const {
  return sqlite3_changes64(db_);
}

Transaction::Transaction(const Database& db) : db_(db) {
  db_.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  if (!open_) return;
  try {
    db_.execute("ROLLBACK");
  } catch (const DatabaseError&) {
    // a full disk makes SQLite roll back by itself; then there is no transaction left to end
  }
}

void Transaction::commit() {
  db_.execute("COMMIT");
  open_ = false;
}

}  // namespace tenter::jobs
