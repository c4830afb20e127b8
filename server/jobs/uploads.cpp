// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/uploads.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <sstream>
#include <system_error>
#include <thread>

#include "common/base/sha256.h"
#include "common/base/sha256_stream.h"
#include "server/jobs/files.h"

namespace tenter::jobs {

namespace fs = std::filesystem;

// One transfer. `writing_` is held while bytes go into the file, so that a chunk is written once
// and its hash stays true; `state_` guards the rest and is never held over disk access. The helper
// thread hashes the leading chunks while later ones arrive, and syncs in the background.
class Uploads::Transfer {
 public:
  Transfer(fs::path folder, UploadRequest request)
      : folder_(std::move(folder)), request_(std::move(request)) {
    chunks_ = (request_.size_bytes + kChunkBytes - 1) / kChunkBytes;
    received_.assign(chunks_, false);
    durable_.assign(chunks_, false);
  }

  const UploadRequest& request() const { return request_; }
  fs::path data_path() const { return folder_ / "data"; }
  const fs::path& folder() const { return folder_; }

  /// Makes the folder's files under another name and renames it: a transfer is whole or absent.
  /// Nothing is synced before the first chunks are: an empty transfer is not worth it.
  Expected<void> create() {
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

  Expected<void> resume() {
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

  Expected<UploadProgress> write(std::uint64_t index, std::string_view bytes) {
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
    const std::uint64_t offset = index * kChunkBytes;
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

  /// Data first, then the bits: a bit on disk means bytes on disk.
  Expected<void> sync() {
    const std::lock_guard one(syncing_);
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

  bool wants_sync() const {
    const std::lock_guard state(state_);
    return received_count_ - durable_count_ >= kChunksPerSync;
  }

  /// Hashes the leading chunks that are there, from where the last call stopped.
  Expected<void> hash_prefix() {
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
                                    static_cast<off_t>(hashed_ * kChunkBytes + have));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return tl::unexpected<Error>(system_error(data_path(), "reading", errno));
        have += static_cast<std::size_t>(got);
      }
      hash_.add(piece);
    }
  }

  /// No chunk is taken afterwards; Error and open again while some are missing.
  Expected<void> close() {
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

  void end() {
    const std::lock_guard writing(writing_);
    closed_ = true;
  }

  /// Of the whole file, after close() and hash_prefix(). Once.
  const std::string& sha256() {
    const std::lock_guard one(hashing_);
    if (digest_.empty()) digest_ = hash_.finish();
    return digest_;
  }

  UploadState state(const std::string& name) const {
    const std::lock_guard state(state_);
    return {name, false, request_.size_bytes, kChunkBytes, chunks_, received_};
  }

  UploadProgress progress_now() const {
    const std::lock_guard state(state_);
    return progress();
  }

 private:
  UploadProgress progress() const { return {received_count_, durable_count_, chunks_}; }
  std::size_t bitmap_bytes() const { return (chunks_ + 7) / 8; }
  std::size_t size_of(std::uint64_t index) const {
    return static_cast<std::size_t>(
        std::min<std::uint64_t>(kChunkBytes, request_.size_bytes - index * kChunkBytes));
  }

  Expected<void> fill(const fs::path& folder) const {
    if (auto done = make_folder(folder); !done) return done;
    auto data = open_file(folder / "data", O_RDWR | O_CREAT | O_EXCL);
    if (!data) return tl::unexpected(data.error());
    const auto size = static_cast<off_t>(request_.size_bytes);
    if (::fallocate(data->get(), 0, 0, size) != 0) {
      if (errno != EOPNOTSUPP || ::ftruncate(data->get(), size) != 0) {
        return tl::unexpected<Error>(system_error(folder / "data", "reserving space", errno));
      }
    }
    const auto write_small = [&folder](const char* name,
                                       const std::string& text) -> Expected<void> {
      auto file = open_file(folder / name, O_WRONLY | O_CREAT | O_EXCL);
      if (!file) return tl::unexpected(file.error());
      return write_all(file->get(), text, folder / name);
    };
    if (auto done = write_small("bitmap", std::string(bitmap_bytes(), '\0')); !done) return done;
    return write_small("request", request_.sha256 + " " + std::to_string(request_.size_bytes) +
                                      " " + request_.user + "\n");
  }

  Expected<void> open_files() {
    auto data = open_file(data_path(), O_RDWR);
    if (!data) return tl::unexpected(data.error());
    auto bitmap = open_file(folder_ / "bitmap", O_RDWR);
    if (!bitmap) return tl::unexpected(bitmap.error());
    data_ = std::move(*data);
    bitmap_ = std::move(*bitmap);
    return {};
  }

  const fs::path folder_;
  const UploadRequest request_;
  std::uint64_t chunks_ = 0;
  FileDescriptor data_, bitmap_;

  std::mutex writing_;
  bool closed_ = false;  // by writing_

  mutable std::mutex state_;
  std::vector<bool> received_, durable_;
  std::uint64_t received_count_ = 0, durable_count_ = 0;

  std::mutex syncing_;
  bool synced_before_ = false;  // by syncing_

  std::mutex hashing_;
  Sha256Stream hash_;
  std::uint64_t hashed_ = 0;
  std::string digest_;
};

// Hashes and syncs behind the back of who brings the chunks; sleeps when there is nothing new.
class Uploads::Helper {
 public:
  Helper() : thread_([this](std::stop_token stop) { run(stop); }) {}

  void look_at(const std::shared_ptr<Transfer>& transfer) {
    {
      const std::lock_guard lock(mutex_);
      if (std::find(waiting_.begin(), waiting_.end(), transfer) != waiting_.end()) return;
      waiting_.push_back(transfer);
    }
    wake_.notify_one();
  }

 private:
  void run(std::stop_token stop) {
    while (!stop.stop_requested()) {
      std::shared_ptr<Transfer> next;
      {
        std::unique_lock lock(mutex_);
        if (!wake_.wait(lock, stop, [this] { return !waiting_.empty(); })) return;
        next = std::move(waiting_.front());
        waiting_.erase(waiting_.begin());
      }
      // failures here are met again, and told, by finish()
      [[maybe_unused]] auto hashed = next->hash_prefix();
      if (next->wants_sync()) [[maybe_unused]]
        auto synced = next->sync();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::vector<std::shared_ptr<Transfer>> waiting_;
  std::jthread thread_;
};

Uploads::Uploads(fs::path folder)
    : folder_(std::move(folder)), helper_(std::make_unique<Helper>()) {}
Uploads::~Uploads() = default;

Expected<std::unique_ptr<Uploads>> Uploads::open(fs::path folder, int keep_days) {
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  std::unique_ptr<Uploads> uploads(new Uploads(std::move(folder)));
  const auto oldest = fs::file_time_type::clock::now() - std::chrono::hours(24 * keep_days);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(uploads->folder_, error)) {
    std::error_code ignored;
    const auto drop = [&] { fs::remove_all(entry.path(), ignored); };
    auto text = read_file(entry.path() / "request", 4096);
    UploadRequest request;
    std::istringstream words(text ? *text : "");
    const bool old = fs::last_write_time(entry.path() / "bitmap", ignored) < oldest;
    if (!(words >> request.sha256 >> request.size_bytes >> request.user) ||
        !is_sha256(request.sha256) || old || entry.path().extension() == ".new") {
      drop();
      continue;
    }
    auto transfer = std::make_shared<Transfer>(entry.path(), request);
    if (!transfer->resume()) {
      drop();
      continue;
    }
    uploads->transfers_[entry.path().filename()] = std::move(transfer);
  }
  return uploads;
}

Expected<UploadState> Uploads::open_transfer(const UploadRequest& request) {
  if (!is_sha256(request.sha256)) {
    return bad_input("'" + request.sha256 + "' is not a SHA-256 in 64 lower-case hex digits");
  }
  if (request.size_bytes == 0) return bad_input("a capture of 0 bytes cannot be uploaded");
  if (request.size_bytes > kLargestBytes) {
    return bad_input("an upload of " + std::to_string(request.size_bytes) +
                     " bytes is larger than the allowed " + std::to_string(kLargestBytes));
  }
  const std::string name =
      sha256_hex(request.user + "\n" + request.sha256 + "\n" + std::to_string(request.size_bytes))
          .substr(0, 32);
  const std::lock_guard lock(mutex_);
  auto& transfer = transfers_[name];
  if (!transfer) {
    auto fresh = std::make_shared<Transfer>(folder_ / name, request);
    if (auto done = fresh->create(); !done) {
      transfers_.erase(name);
      return tl::unexpected(done.error());
    }
    transfer = std::move(fresh);
  }
  return transfer->state(name);
}

Expected<std::shared_ptr<Uploads::Transfer>> Uploads::find(const std::string& transfer) const {
  const std::lock_guard lock(mutex_);
  const auto found = transfers_.find(transfer);
  if (found == transfers_.end()) {
    return fail(ErrorKind::not_found, "there is no open transfer '" + transfer.substr(0, 64) + "'");
  }
  return found->second;
}

Expected<UploadProgress> Uploads::write_chunk(const std::string& transfer, std::uint64_t index,
                                              std::string_view bytes) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  auto progress = (*found)->write(index, bytes);
  if (progress) helper_->look_at(*found);
  return progress;
}

Expected<UploadProgress> Uploads::sync(const std::string& transfer) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  if (auto done = (*found)->sync(); !done) return tl::unexpected(done.error());
  return (*found)->progress_now();
}

Expected<UploadRequest> Uploads::request(const std::string& transfer) const {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  return (*found)->request();
}

Expected<Uploads::Finished> Uploads::finish(const std::string& transfer) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  Transfer& it = **found;
  if (auto done = it.close(); !done) return tl::unexpected(done.error());
  Expected<void> synced;
  std::thread syncing([&] { synced = it.sync(); });  // the disk writes while the hash is finished
  const auto hashed = it.hash_prefix();
  syncing.join();
  if (!synced) return tl::unexpected(synced.error());
  if (!hashed) return tl::unexpected(hashed.error());
  if (it.sha256() != it.request().sha256) {
    const std::string message = "the uploaded bytes have the hash " + it.sha256() +
                                " instead of the promised " + it.request().sha256 +
                                "; the upload was dropped";
    if (auto done = drop(transfer); !done) return tl::unexpected(done.error());
    return bad_input(message);
  }
  return Finished{it.data_path(), it.request()};
}

Expected<void> Uploads::drop(const std::string& transfer) {
  auto found = find(transfer);
  if (!found) return tl::unexpected(found.error());
  (*found)->end();
  const std::lock_guard lock(mutex_);
  std::error_code error;
  fs::remove_all((*found)->folder(), error);
  transfers_.erase(transfer);
  if (error)
    return tl::unexpected<Error>(system_error((*found)->folder(), "removing", error.value()));
  return {};
}

std::uint64_t Uploads::pending_bytes(const std::string& user,
                                     const std::string& except_sha256) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const auto& [name, transfer] : transfers_) {
    if (transfer->request().user == user && transfer->request().sha256 != except_sha256)
      sum += transfer->request().size_bytes;
  }
  return sum;
}

}  // namespace tenter::jobs
