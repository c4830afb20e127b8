// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/store/upload_transfer.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "common/base/crc32c.h"
#include "common/base/sha256.h"
#include "common/base/sha256_stream.h"

namespace tenter::jobs {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kPresent = std::uint64_t{0x6b6e6863} << 32;  // "chnk" above the checksum
constexpr std::size_t kPiece = std::size_t{1} << 18;                 // stays in the cache

}  // namespace

UploadTransfer::UploadTransfer(fs::path folder, UploadRequest request)
    : folder_(std::move(folder)), request_(std::move(request)) {
  chunks_ = (request_.size_bytes + Uploads::kChunkBytes - 1) / Uploads::kChunkBytes;
  received_.assign(chunks_, false);
  durable_.assign(chunks_, false);
  crc32c_.assign(chunks_, 0);
}

Expected<void> UploadTransfer::create() {
  fs::path beside = folder_;
  beside += ".new";
  std::error_code ignored;
  fs::remove_all(beside, ignored);
  auto done = fill(beside);
  if (done && ::rename(beside.c_str(), folder_.c_str()) != 0) {
    done = tl::unexpected<Error>(system_error(folder_, "moving into place", errno));
  }
  if (!done) {
    fs::remove_all(beside, ignored);
    if (done.error().kind == ErrorKind::no_space) {
      return fail(ErrorKind::no_space, "the store's disk has no room for an upload of " +
                                           std::to_string(request_.size_bytes) + " bytes");
    }
    return done;
  }
  return open_files();
}

Expected<void> UploadTransfer::resume() {
  auto marks = read_file(folder_ / "chunks", marks_bytes());
  if (!marks) return tl::unexpected(marks.error());
  auto stamp = stamp_of(data_path());
  if (!stamp) return tl::unexpected(stamp.error());
  if (marks->size() != marks_bytes() || stamp->size != request_.size_bytes) {
    return fail(ErrorKind::internal, folder_.string() + ": the half-received capture is damaged");
  }
  for (std::uint64_t i = 0; i < chunks_; ++i) {
    std::uint64_t mark = 0;
    std::memcpy(&mark, marks->data() + i * sizeof mark, sizeof mark);
    const bool there = (mark >> 32) == (kPresent >> 32);
    received_[i] = durable_[i] = there;
    received_count_ += there;
    durable_count_ += there;
    crc32c_[i] = static_cast<std::uint32_t>(mark);
  }
  return open_files();
}

Expected<UploadProgress> UploadTransfer::write(std::uint64_t index, std::string_view bytes,
                                               std::uint32_t crc32c) {
  if (index >= chunks_) {
    return bad_input("chunk " + std::to_string(index) + " is beyond the last of " +
                     std::to_string(chunks_) + " chunks");
  }
  if (bytes.size() != size_of(index)) {
    return bad_input("chunk " + std::to_string(index) + " has " + std::to_string(bytes.size()) +
                     " bytes instead of " + std::to_string(size_of(index)));
  }
  const std::lock_guard writing(writing_);
  if (closed_) return fail(ErrorKind::not_found, "the transfer has ended");
  {
    const std::lock_guard state(state_);
    if (received_[index]) return progress();
  }
  const std::uint64_t offset = index * Uploads::kChunkBytes;
  if (auto done = write_all_at(data_.get(), bytes, offset, data_path()); !done) {
    return tl::unexpected(done.error());
  }
  // starts the disk early, so that the syncs find little left to do
  ::sync_file_range(data_.get(), static_cast<off_t>(offset), static_cast<off_t>(bytes.size()),
                    SYNC_FILE_RANGE_WRITE);
  const std::lock_guard state(state_);
  received_[index] = true;
  crc32c_[index] = crc32c;
  ++received_count_;
  return progress();
}

Expected<void> UploadTransfer::sync() {
  const std::lock_guard one(syncing_);
  if (sync_lost_) return tl::unexpected<Error>(*sync_lost_);
  auto done = sync_once();
  if (!done) sync_lost_ = done.error();
  return done;
}

Expected<void> UploadTransfer::sync_once() {
  std::vector<bool> upto;
  std::vector<std::uint64_t> marks;  // from the first new one to the last
  std::uint64_t count = 0, first = 0;
  {
    const std::lock_guard state(state_);
    if (durable_count_ == received_count_) return {};
    upto = received_;
    count = received_count_;
    while (durable_[first] == received_[first]) ++first;
    std::uint64_t end = chunks_;
    while (durable_[end - 1] == received_[end - 1]) --end;
    for (std::uint64_t i = first; i < end; ++i)
      marks.push_back(received_[i] ? kPresent | crc32c_[i] : 0);
  }
  if (!synced_before_) {
    if (auto done = sync_file(folder_ / "request"); !done) return done;
    for (const auto& folder : {folder_, folder_.parent_path()}) {
      if (auto done = sync_folder(folder); !done) return done;
    }
    synced_before_ = true;
  }
  if (::fdatasync(data_.get()) != 0) {
    return tl::unexpected<Error>(system_error(data_path(), "writing to disk", errno));
  }
  const std::string_view bytes(reinterpret_cast<const char*>(marks.data()),
                               marks.size() * sizeof marks[0]);
  if (auto done = write_all_at(marks_.get(), bytes, first * sizeof marks[0], folder_ / "chunks");
      !done)
    return done;
  if (::fdatasync(marks_.get()) != 0) {
    return tl::unexpected<Error>(system_error(folder_ / "chunks", "writing to disk", errno));
  }
  const std::lock_guard state(state_);
  durable_ = std::move(upto);
  durable_count_ = count;
  return {};
}

bool UploadTransfer::wants_sync() const {
  const std::lock_guard state(state_);
  return received_count_ - durable_count_ >= Uploads::kChunksPerSync;
}

Expected<void> UploadTransfer::close() {
  const std::lock_guard writing(writing_);
  const std::lock_guard state(state_);
  if (received_count_ != chunks_) {
    const auto missing = std::find(received_.begin(), received_.end(), false);
    return fail(ErrorKind::refused, std::to_string(chunks_ - received_count_) + " of " +
                                        std::to_string(chunks_) +
                                        " chunks are missing, the first is " +
                                        std::to_string(missing - received_.begin()));
  }
  closed_ = true;
  return {};
}

void UploadTransfer::end() {
  const std::lock_guard writing(writing_);
  closed_ = true;
}

std::string UploadTransfer::checksums() const {
  std::string bytes;
  const std::lock_guard state(state_);
  for (const std::uint32_t crc : crc32c_)
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(crc >> shift);
  return sha256_hex(bytes);
}

Expected<std::string> UploadTransfer::sha256() {
  const std::lock_guard one(hashing_);
  if (!digest_.empty()) return digest_;
  Sha256Stream hash;
  std::vector<char> piece(std::min<std::uint64_t>(kPiece, request_.size_bytes));
  std::uint32_t crc = 0;
  for (std::uint64_t at = 0; at < request_.size_bytes;) {
    const std::uint64_t index = at / Uploads::kChunkBytes, into = at % Uploads::kChunkBytes;
    const std::size_t wanted = std::min<std::size_t>(kPiece, size_of(index) - into);
    for (std::size_t have = 0; have < wanted;) {
      const ssize_t got =
          ::pread(data_.get(), piece.data() + have, wanted - have, static_cast<off_t>(at + have));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return tl::unexpected<Error>(system_error(data_path(), "reading", errno));
      have += static_cast<std::size_t>(got);
    }
    hash.add({piece.data(), wanted});
    crc = crc32c(piece.data(), wanted, into == 0 ? 0 : crc);
    at += wanted;
    if (into + wanted < size_of(index)) continue;
    const std::lock_guard state(state_);
    if (crc != crc32c_[index])
      return fail(ErrorKind::bad_input,
                  "chunk " + std::to_string(index) + " is not on the disk as it was received");
  }
  digest_ = hash.finish();
  return digest_;
}

UploadState UploadTransfer::state(const std::string& name) const {
  const std::lock_guard state(state_);
  return {name, false, request_.size_bytes, Uploads::kChunkBytes, chunks_, received_};
}

UploadProgress UploadTransfer::progress_now() const {
  const std::lock_guard state(state_);
  return progress();
}

std::size_t UploadTransfer::size_of(std::uint64_t index) const {
  return static_cast<std::size_t>(std::min<std::uint64_t>(
      Uploads::kChunkBytes, request_.size_bytes - index * Uploads::kChunkBytes));
}

Expected<void> UploadTransfer::fill(const fs::path& folder) const {
  if (auto done = make_folder(folder); !done) return done;
  auto data = open_file(folder / "data", O_RDWR | O_CREAT | O_EXCL);
  if (!data) return tl::unexpected(data.error());
  const auto size = static_cast<off_t>(request_.size_bytes);
  if (::fallocate(data->get(), 0, 0, size) != 0) {
    if (errno != EOPNOTSUPP || ::ftruncate(data->get(), size) != 0) {
      return tl::unexpected<Error>(system_error(folder / "data", "reserving space", errno));
    }
  }
  const auto write_small = [&folder](const char* name, const std::string& text) -> Expected<void> {
    auto file = open_file(folder / name, O_WRONLY | O_CREAT | O_EXCL);
    if (!file) return tl::unexpected(file.error());
    return write_all(file->get(), text, folder / name);
  };
  if (auto done = write_small("chunks", std::string(marks_bytes(), '\0')); !done) return done;
  return write_small("request", request_.sha256 + " " + std::to_string(request_.size_bytes) + " " +
                                    request_.user + "\n");
}

Expected<void> UploadTransfer::open_files() {
  auto data = open_file(data_path(), O_RDWR);
  if (!data) return tl::unexpected(data.error());
  auto marks = open_file(folder_ / "chunks", O_RDWR);
  if (!marks) return tl::unexpected(marks.error());
  data_ = std::move(*data);
  marks_ = std::move(*marks);
  return {};
}

}  // namespace tenter::jobs
