// SPDX-License-Identifier: GPL-3.0-or-later
// One half-received capture on disk: FOLDER/{data, chunks, request}. Inside uploads.cpp only; the
// contract is there.
//
// `chunks` has eight bytes for every chunk: a mark that it is there, and its CRC-32C as the sender
// gave it. `writing_` is held while bytes go into the file, so that a chunk is written once and its
// checksum stays true; `state_` guards the rest and is never held over disk access. Syncing may run
// beside the writing, once at a time.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "server/jobs/store/files.h"
#include "server/jobs/store/uploads.h"

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

  /// `crc32c` is that of `bytes`, checked by who received them.
  Expected<UploadProgress> write(std::uint64_t index, std::string_view bytes, std::uint32_t crc32c);
  /// Data first, then the marks: a mark on disk means bytes on disk. A failure is remembered,
  /// because the kernel tells of lost pages once only.
  Expected<void> sync();
  bool wants_sync() const;
  /// No chunk is taken afterwards; an Error, and still open, while some are missing.
  Expected<void> close();
  void end();
  /// SHA-256 of the checksums of all chunks, four bytes each, least first; after close().
  std::string checksums() const;
  /// The file is the one that the client means: its checksums() are those of the client.
  void confirm() { confirmed_ = true; }
  bool confirmed() const { return confirmed_; }
  /// Of the whole file as it is read back, after close(). An Error when a chunk no longer has its
  /// checksum.
  Expected<std::string> sha256();

  UploadState state(const std::string& name) const;
  UploadProgress progress_now() const;

 private:
  UploadProgress progress() const { return {received_count_, durable_count_, chunks_}; }
  std::size_t marks_bytes() const { return chunks_ * sizeof(std::uint64_t); }
  std::size_t size_of(std::uint64_t index) const;
  Expected<void> fill(const std::filesystem::path& folder) const;
  Expected<void> open_files();
  Expected<void> sync_once();

  const std::filesystem::path folder_;
  const UploadRequest request_;
  std::uint64_t chunks_ = 0;
  FileDescriptor data_, marks_;
  std::atomic<bool> confirmed_{false};

  std::mutex writing_;
  bool closed_ = false;  // by writing_

  mutable std::mutex state_;
  std::vector<bool> received_, durable_;
  std::vector<std::uint32_t> crc32c_;  // of what was received
  std::uint64_t received_count_ = 0, durable_count_ = 0;

  std::mutex syncing_;
  bool synced_before_ = false;      // by syncing_
  std::optional<Error> sync_lost_;  // by syncing_

  std::mutex hashing_;
  std::string digest_;  // by hashing_
};

}  // namespace tenter::jobs
