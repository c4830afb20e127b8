// SPDX-License-Identifier: GPL-3.0-or-later
// Half-received captures: a transfer is a folder with the bytes so far and a bitmap of the chunks
// that are on disk.
//
//   auto state = uploads.open({.user = "ada", .sha256 = sha, .size_bytes = size});
//   for each chunk missing in state->present: uploads.write_chunk(state->transfer, index, bytes);
//   auto file = uploads.finish(state->transfer);       // all there, hash right, durable
//
// The transfer's name follows from user, hash and size, so opening again, also after a restart,
// resumes. A chunk counts as durable, and is shown present after a restart, only once data and
// bitmap were synced: every kChunksPerSync chunks, on sync() and on finish(). Any thread; chunks of
// different transfers do not wait for each other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"

namespace tenter::jobs {

struct UploadRequest {
  std::string user;
  std::string sha256;
  std::uint64_t size_bytes = 0;
};

struct UploadState {
  std::string transfer;  ///< "" when the store has the capture already
  bool already_stored = false;
  std::uint64_t size_bytes = 0;
  std::uint32_t chunk_bytes = 0;  ///< every chunk but the last has this size
  std::uint64_t chunks = 0;
  std::vector<bool> present;  ///< chunks that need not be sent
};

struct UploadProgress {
  std::uint64_t received = 0;  ///< chunks, each counted once
  std::uint64_t durable = 0;   ///< of them on disk
  std::uint64_t chunks = 0;
};

class UploadTransfer;

class Uploads {
 public:
  static constexpr std::uint32_t kChunkBytes = 1u << 20;
  static constexpr int kChunksPerSync = 16;
  static constexpr std::uint64_t kLargestBytes = 1ull << 40;

  /// Opens or makes the area; drops transfers untouched for `keep_days` (by the wall clock; nothing
  /// else depends on it).
  static Expected<std::unique_ptr<Uploads>> open(std::filesystem::path folder, int keep_days = 7);
  ~Uploads();

  /// Reserves the space on disk first: a full disk is refused here, before the first chunk.
  Expected<UploadState> open_transfer(const UploadRequest& request);
  Expected<UploadProgress> write_chunk(const std::string& transfer, std::uint64_t index,
                                       std::string_view bytes);
  Expected<UploadProgress> sync(const std::string& transfer);
  Expected<UploadRequest> request(const std::string& transfer) const;

  struct Finished {
    std::filesystem::path path;
    UploadRequest request;
  };
  /// Refuses while chunks are missing; on a wrong hash the transfer is dropped. The file stays in
  /// the area until drop(); renaming it into the store is the caller's. `sha256`, when given, takes
  /// the place of the one promised when the transfer was opened: a client that hashes while it
  /// sends opens with any 64 hex digits that name the file.
  Expected<Finished> finish(const std::string& transfer, const std::string& sha256 = {});
  Expected<void> drop(const std::string& transfer);

  /// Bytes promised to open transfers of this user, that of `except_sha256` not counted.
  std::uint64_t pending_bytes(const std::string& user, const std::string& except_sha256 = "") const;

 private:
  class Helper;
  explicit Uploads(std::filesystem::path folder);
  Expected<std::shared_ptr<UploadTransfer>> find(const std::string& transfer) const;

  std::filesystem::path folder_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<UploadTransfer>> transfers_;
  std::unique_ptr<Helper> helper_;
};

}  // namespace tenter::jobs
