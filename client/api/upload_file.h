// SPDX-License-Identifier: Apache-2.0
// The file that an upload sends: its chunks in the order in which they go out, read ahead, each
// with its checksum.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.h"
#include "common/wire/uuid.h"
#include "tenter_v1.h"

namespace tenter::client {

class UploadFile {
 public:
  explicit UploadFile(std::filesystem::path path);
  ~UploadFile();
  UploadFile(const UploadFile&) = delete;
  UploadFile& operator=(const UploadFile&) = delete;

  /// Before anything else; an Error when it cannot be read or is empty.
  Expected<void> open();
  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  std::uint64_t chunks() const { return crc32c_.size(); }

  /// A name for a large file that costs nothing: the SHA-256 of its size, its time, its first and
  /// last megabyte. Two files with one name do no harm: checksums() tells them apart.
  Expected<std::string> stand_in() const;
  /// Index, data and checksum of one chunk.
  Expected<void> fill(wire::v1::Chunk& chunk, std::uint64_t index);
  /// SHA-256 of the CRC-32C of all chunks, four bytes each, least first; reads those that were
  /// never filled.
  Expected<std::string> checksums();
  /// Of the whole file, in the calling thread; "" when `stop` came first.
  Expected<std::string> sha256(const std::stop_token& stop) const;

 private:
  Expected<void> read_at(std::uint64_t offset, void* data, std::size_t size) const;

  const std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::vector<std::optional<std::uint32_t>> crc32c_;
};

/// Fills chunks in a thread of its own, a few before they are asked for, so that reading the file
/// and writing to the wire overlap. The file is this object's alone while it lives.
class ReadAhead {
 public:
  ReadAhead(UploadFile& file, std::vector<std::uint64_t> indices, const wire::Uuid& transfer);

  /// The next one, valid until the call after this; null after the last.
  Expected<wire::v1::Chunk*> next();

 private:
  static constexpr std::size_t kAhead = 4;
  void run(const std::stop_token& stop);

  UploadFile& file_;
  const std::vector<std::uint64_t> indices_;
  std::vector<wire::v1::Chunk> ring_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::size_t filled_ = 0, taken_ = 0;
  std::optional<Error> failed_;
  std::jthread thread_;  ///< last: it uses the others
};

/// The SHA-256 of a file, made beside its sending: where sending is slow it is known long before
/// all is sent, and may show that the server has the file. Ends with the object.
class HashBeside {
 public:
  explicit HashBeside(const UploadFile& file);
  /// "" while it is not known; when the file cannot be read, for ever.
  std::string known() const { return ready_ ? hash_ : std::string(); }
  void stop() { thread_.request_stop(); }

 private:
  std::string hash_;
  std::atomic<bool> ready_{false};
  std::jthread thread_;
};

}  // namespace tenter::client
