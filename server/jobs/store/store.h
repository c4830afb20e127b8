// SPDX-License-Identifier: GPL-3.0-or-later
// The content-addressed store: files named by the SHA-256 of their bytes, whole or not there.
//
//   objects/ab/cdef...   read-only files        tmp/   being written; emptied at start-up
//   damaged/             objects whose bytes no longer have their name, kept for a look
//
//   auto sha = store.adopt(staging / "result.json");   // synced, moved in
//   auto path = store.path(*sha);                      // checked against its name on first use
//
// An object appears by rename after its bytes are on disk, so kill -9 or a full disk leaves none
// half-written. A flipped bit is found when the object is next read, and the object set aside, so
// that the same bytes can be stored again. Any thread.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/store/files.h"

namespace tenter::jobs {

class Store {
 public:
  static Expected<std::unique_ptr<Store>> open(std::filesystem::path folder);

  /// Stores the bytes; returns their hash.
  Expected<std::string> put(std::string_view bytes);
  /// Moves the file in (it must be on the store's file system); returns its hash. With
  /// `known_sha256` the bytes are not read again: the caller has just hashed this very file.
  Expected<std::string> adopt(const std::filesystem::path& file,
                              const std::string& known_sha256 = "");

  /// The object's file, its bytes checked once per life of the daemon (again if the file changes).
  /// not_found when missing, internal when damaged.
  Expected<std::filesystem::path> path(const std::string& sha256);
  /// There, with that size, without reading it. `size` 0: any.
  Expected<void> check_present(const std::string& sha256, std::uint64_t size) const;
  bool contains(const std::string& sha256) const { return check_present(sha256, 0).has_value(); }

  std::uint64_t free_bytes() const;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  explicit Store(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path object(const std::string& sha256) const;
  std::filesystem::path temporary();
  Expected<void> set_aside(const std::string& sha256);
  Expected<void> move_in(const std::filesystem::path& file, const std::string& sha256);

  std::filesystem::path folder_;
  std::mutex mutex_;
  std::map<std::string, FileStamp> verified_;
  std::uint64_t next_temporary_ = 0;
};

}  // namespace tenter::jobs
