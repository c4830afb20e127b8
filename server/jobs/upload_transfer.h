// SPDX-License-Identifier: GPL-3.0-or-later
// One half-received capture on disk: FOLDER/{data, bitmap, request}. Inside uploads.cpp only; the
// contract is there.
//
// `writing_` is held while bytes go into the file, so that a chunk is written once and its hash
// stays true; `state_` guards the rest and is never held over disk access. Hashing and syncing may
// run beside the writing, each once at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "common/base/sha256_stream.h"
#include "server/jobs/files.h"
#include "server/jobs/uploads.h"

namespace tenter::jobs {

class UploadTransfer {
 public:
  UploadTransfer(std::filesystem::path folder, UploadRequest request);

  const UploadRequest& request() const { return request_; }
  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path data_path() const { return folder_ / "data"; }

  /// Makes the folder's files under another name and renames it: a transfer is whole or absent.
  /// Nothing is synced before the first chunks are: an empty transfer is not worth it.
  Expected<void> create();
  /// Reads what an earlier daemon left.
  Expected<void> resume();

  Expected<UploadProgress> write(std::uint64_t index, std::string_view bytes);
  /// Data first, then the bits: a bit on disk means bytes on disk. A failure is remembered, because
  /// the kernel tells of lost pages once only.
  Expected<void> sync();
  bool wants_sync() const;
  /// Hashes the leading chunks that are there, from where the last call stopped.
  Expected<void> hash_prefix();
  /// No chunk is taken afterwards; an Error, and still open, while some are missing.
  Expected<void> close();
  void end();
  /// Of the whole file, after close() and hash_prefix().
  const std::string& sha256();

  UploadState state(const std::string& name) const;
  UploadProgress progress_now() const;

 private:
  UploadProgress progress() const { return {received_count_, durable_count_, chunks_}; }
  std::size_t bitmap_bytes() const { return (chunks_ + 7) / 8; }
  std::size_t size_of(std::uint64_t index) const;
  Expected<void> fill(const std::filesystem::path& folder) const;
  Expected<void> open_files();
  Expected<void> sync_once();

  const std::filesystem::path folder_;
  const UploadRequest request_;
  std::uint64_t chunks_ = 0;
  FileDescriptor data_, bitmap_;

  std::mutex writing_;
  bool closed_ = false;  // by writing_

  mutable std::mutex state_;
  std::vector<bool> received_, durable_;
  std::uint64_t received_count_ = 0, durable_count_ = 0;

  std::mutex syncing_;
  bool synced_before_ = false;      // by syncing_
  std::optional<Error> sync_lost_;  // by syncing_

  std::mutex hashing_;
  Sha256Stream hash_;
  std::uint64_t hashed_ = 0;
  std::string digest_;
};

}  // namespace tenter::jobs
