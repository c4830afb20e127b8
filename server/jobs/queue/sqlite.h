// SPDX-License-Identifier: GPL-3.0-or-later
// SQLite's C interface with owners: a connection, a statement, a transaction.
//
//   Statement find = db.prepare("SELECT state FROM jobs WHERE id = ?");
//   find.bind(1, id);
//   while (find.step()) use(find.text(0));
//
// Inside server/jobs only. Failures are thrown as DatabaseError and become an Error at the queue's
// public functions (as_expected): dozens of statements in one transaction read better so. A
// connection belongs to one thread at a time; its owner holds the lock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace tenter::jobs {

struct DatabaseError {
  Error error;
  bool damaged = false;  ///< SQLITE_CORRUPT or SQLITE_NOTADB: the file, not the moment
};

class Statement {
 public:
  Statement(sqlite3* db, std::string_view sql);
  ~Statement();
  Statement(Statement&& other) noexcept;
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  Statement& operator=(Statement&&) = delete;

  // places count from 1
  Statement& bind(int place, std::int64_t value);
  Statement& bind(int place, double value);
  Statement& bind(int place, std::string_view value);
  Statement& bind_null(int place);
  Statement& reset();

  /// True while there is a row.
  bool step();
  /// For statements without rows.
  void run() { step(); }

  // columns count from 0
  int columns() const;
  bool is_null(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;
  std::string column_name(int column) const;
  /// Copies one column, whatever its type, to a place of another statement.
  void copy_to(int column, Statement& other, int place) const;

 private:
  sqlite3* db_;
  sqlite3_stmt* statement_ = nullptr;
};

class Database {
 public:
  enum class Mode { read_write, read_only };
  /// WAL, synchronous=FULL, foreign keys on, 10 s busy time-out. Throws.
  Database(const std::filesystem::path& file, Mode mode);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  Statement prepare(std::string_view sql) const { return Statement(db_, sql); }
  /// One or several statements without parameters or rows.
  void execute(const std::string& sql) const;
  std::int64_t last_row_id() const;
  /// Rows changed by the last INSERT, UPDATE or DELETE.
  std::int64_t changes() const;

 private:
  sqlite3* db_ = nullptr;
};

/// BEGIN IMMEDIATE ... commit(), or ROLLBACK when left without.
class Transaction {
 public:
  explicit Transaction(const Database& db);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  const Database& db_;
  bool open_ = true;
};

/// Runs `body` (returning Expected<T>) and turns a DatabaseError into its Error.
template <class Body>
auto as_expected(Body&& body) -> decltype(body()) {
  try {
    return body();
  } catch (const DatabaseError& trouble) {
    return tl::unexpected<Error>(trouble.error);
  }
}

}  // namespace tenter::jobs
