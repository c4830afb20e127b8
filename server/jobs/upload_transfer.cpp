// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/upload_transfer.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace tenter::jobs {

namespace fs = std::filesystem;

UploadTransfer::UploadTransfer(fs::path folder, UploadRequest request)
    : folder_(std::move(folder)), request_(std::move(request)) {
  chunks_ = (request_.size_bytes + Uploads::kChunkBytes - 1) / Uploads::kChunkBytes;
  received_.assign(chunks_, false);
  durable_.assign(chunks_, false);
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
  auto bits = read_file(folder_ / "bitmap", bitmap_bytes());
  if (!bits) return tl::unexpected(bits.error());
  auto stamp = stamp_of(data_path());
  if (!stamp) return tl::unexpected(stamp.error());
  if (bits->size() != bitmap_bytes() || stamp->size != request_.size_bytes) {
    return fail(ErrorKind::internal, folder_.string() + ": the half-received capture is damaged");
  }
  for (std::uint64_t i = 0; i < chunks_; ++i) {
    const bool bit = (static_cast<unsigned char>((*bits)[i / 8]) >> (i % 8)) & 1;
    received_[i] = durable_[i] = bit;
    received_count_ += bit;
    durable_count_ += bit;
  }
  return open_files();
}

Expected<UploadProgress> UploadTransfer::write(std::uint64_t index, std::string_view bytes) {
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
  std::uint64_t count = 0;
  {
    const std::lock_guard state(state_);
    if (durable_count_ == received_count_) return {};
    upto = received_;
    count = received_count_;
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
  std::string bits(bitmap_bytes(), '\0');
  for (std::uint64_t i = 0; i < chunks_; ++i) {
    if (upto[i]) bits[i / 8] = static_cast<char>(bits[i / 8] | (1 << (i % 8)));
  }
  if (auto done = write_all_at(bitmap_.get(), bits, 0, folder_ / "bitmap"); !done) return done;
  if (::fdatasync(bitmap_.get()) != 0) {
    return tl::unexpected<Error>(system_error(folder_ / "bitmap", "writing to disk", errno));
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

Expected<void> UploadTransfer::hash_prefix() {
  const std::lock_guard one(hashing_);
  std::string piece;
  for (;; ++hashed_) {
    {
      const std::lock_guard state(state_);
      if (hashed_ == chunks_ || !received_[hashed_]) return {};
    }
    piece.resize(size_of(hashed_));
    std::size_t have = 0;
    while (have < piece.size()) {
      const ssize_t got = ::pread(data_.get(), piece.data() + have, piece.size() - have,
                                  static_cast<off_t>(hashed_ * Uploads::kChunkBytes + have));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return tl::unexpected<Error>(system_error(data_path(), "reading", errno));
      have += static_cast<std::size_t>(got);
    }
    hash_.add(piece);
  }
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

const std::string& UploadTransfer::sha256() {
  const std::lock_guard one(hashing_);
  if (digest_.empty()) digest_ = hash_.finish();
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
  if (auto done = write_small("bitmap", std::string(bitmap_bytes(), '\0')); !done) return done;
  return write_small("request", request_.sha256 + " " + std::to_string(request_.size_bytes) + " " +
                                    request_.user + "\n");
}

Expected<void> UploadTransfer::open_files() {
  auto data = open_file(data_path(), O_RDWR);
  if (!data) return tl::unexpected(data.error());
  auto bitmap = open_file(folder_ / "bitmap", O_RDWR);
  if (!bitmap) return tl::unexpected(bitmap.error());
  data_ = std::move(*data);
  bitmap_ = std::move(*bitmap);
  return {};
}

}  // namespace tenter::jobs
