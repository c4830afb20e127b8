// SPDX-License-Identifier: GPL-3.0-or-later
// Half-received captures: a transfer is a folder with the bytes so far and a list of the chunks
// that are on disk, with their checksums.
//
//   auto state = uploads.open({.user = "ada", .sha256 = sha, .size_bytes = size});
//   for each chunk missing in state->present: uploads.write_chunk(state->transfer, index, bytes);
//   auto file = uploads.finish(state->transfer);       // all there, hash right, durable
//
// The transfer's name follows from user, hash and size, so opening again, also after a restart,
// resumes. A chunk counts as durable, and is shown present after a restart, only once data and
// list were synced: every kChunksPerSync chunks, on sync() and on seal(). Any thread; chunks of
// different transfers do not wait for each other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
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
  /// `crc32c` is that of `bytes` where the caller has checked it already.
  Expected<UploadProgress> write_chunk(const std::string& transfer, std::uint64_t index,
                                       std::string_view bytes,
                                       std::optional<std::uint32_t> crc32c = std::nullopt);
  Expected<UploadProgress> sync(const std::string& transfer);
  Expected<UploadRequest> request(const std::string& transfer) const;

  struct Finished {
    std::filesystem::path path;
    UploadRequest request;
  };
  /// No chunk is taken afterwards and all are on disk; the file. Refuses while chunks are missing.
  Expected<std::filesystem::path> seal(const std::string& transfer);
  /// Seals, and compares the SHA-256 of the chunks' CRC-32C (four bytes each, least first) with the
  /// client's. Then the whole file is here as the client read it: each chunk was compared when it
  /// came, the list says that they are the chunks of one file in this order, and no byte was read
  /// again for it. Else bad_input, and the transfer is dropped.
  Expected<void> confirm(const std::string& transfer, const std::string& checksums);
  /// Seals and reads the file once: its SHA-256, and whether each chunk still has its checksum, so
  /// that the name is that of the bytes received. The file stays in the area until drop(); renaming
  /// it into the store is the caller's. The hash must be `sha256`; if that is not given, the one
  /// promised when the transfer was opened; after confirm() none is needed: a client that
  /// does not hash opens with any 64 hex digits that name the file. On a wrong one the transfer is
  /// dropped.
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
