// SPDX-License-Identifier: Apache-2.0
#include "client/api/upload_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "common/base/crc32c.h"
#include "common/base/sha256.h"
#include "common/base/sha256_stream.h"

namespace tenter::client {

namespace v1 = wire::v1;
namespace fs = std::filesystem;

UploadFile::UploadFile(fs::path path) : path_(std::move(path)) {}

UploadFile::~UploadFile() {
  if (file_ >= 0) ::close(file_);
}

Expected<void> UploadFile::open() {
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat found {};
  if (file_ < 0 || ::fstat(file_, &found) != 0 || !S_ISREG(found.st_mode))
    return fail(ErrorKind::not_found, path_.string() + ": cannot be read as a file");
  if (found.st_size == 0) return bad_input(path_.string() + ": the file is empty");
  size_ = static_cast<std::uint64_t>(found.st_size);
  crc32c_.resize((size_ + v1::CHUNK_BYTES - 1) / v1::CHUNK_BYTES);
  return {};
}

Expected<std::string> UploadFile::stand_in() const {
  struct stat found {};
  const std::size_t part = std::min<std::uint64_t>(v1::CHUNK_BYTES, size_);
  std::string ends(2 * part, '\0');
  if (::fstat(file_, &found) != 0)
    return bad_input(path_.string() + ": became unreadable while it was sent");
  if (auto done = read_at(0, ends.data(), part); !done) return tl::unexpected(done.error());
  if (auto done = read_at(size_ - part, ends.data() + part, part); !done)
    return tl::unexpected(done.error());
  return sha256_hex(std::to_string(size_) + ' ' + std::to_string(found.st_mtim.tv_sec) + '.' +
                    std::to_string(found.st_mtim.tv_nsec) + ' ' + ends);
}

Expected<void> UploadFile::fill(v1::Chunk& chunk, std::uint64_t index) {
  const std::uint64_t offset = index * v1::CHUNK_BYTES;
  auto& data = chunk.data();
  data.resize(std::min<std::uint64_t>(v1::CHUNK_BYTES, size_ - offset));
  if (auto done = read_at(offset, data.data(), data.size()); !done) return done;
  chunk.index(static_cast<std::uint32_t>(index));
  chunk.crc32c(crc32c(data.data(), data.size()));
  crc32c_[index] = chunk.crc32c();
  return {};
}

Expected<std::string> UploadFile::checksums() {
  v1::Chunk chunk;
  std::string bytes;
  for (std::uint64_t index = 0; index < chunks(); ++index) {
    if (!crc32c_[index])
      if (auto done = fill(chunk, index); !done) return tl::unexpected(done.error());
    for (int shift = 0; shift < 32; shift += 8)
      bytes += static_cast<char>(*crc32c_[index] >> shift);
  }
  return sha256_hex(bytes);
}

Expected<std::string> UploadFile::sha256(const std::stop_token& stop) const {
  Sha256Stream hash;
  std::vector<char> piece(std::size_t{1} << 16);
  for (std::uint64_t at = 0; at < size_; at += piece.size()) {
    if (stop.stop_requested()) return std::string();
    const std::size_t size = std::min<std::uint64_t>(piece.size(), size_ - at);
    if (auto done = read_at(at, piece.data(), size); !done) return tl::unexpected(done.error());
    hash.add({piece.data(), size});
  }
  return hash.finish();
}

Expected<void> UploadFile::read_at(std::uint64_t offset, void* data, std::size_t size) const {
  for (std::size_t done = 0; done < size;) {
    const ssize_t got = ::pread(file_, static_cast<char*>(data) + done, size - done,
                                static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      return bad_input(path_.string() + ": changed or became unreadable while it was sent");
    done += static_cast<std::size_t>(got);
  }
  return {};
}

ReadAhead::ReadAhead(UploadFile& file, std::vector<std::uint64_t> indices,
                     const wire::Uuid& transfer)
    : file_(file), indices_(std::move(indices)), ring_(kAhead) {
  for (v1::Chunk& chunk : ring_) {
    chunk.transfer_id(transfer);
    chunk.count(static_cast<std::uint32_t>(file.chunks()));
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void ReadAhead::run(const std::stop_token& stop) {
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    {
      std::unique_lock lock(mutex_);
      // one less than there is room for: the one taken last is still in use
      if (!changed_.wait(lock, stop, [&] { return i + 1 < taken_ + kAhead; })) return;
    }
    auto done = file_.fill(ring_[i % kAhead], indices_[i]);
    {
      const std::lock_guard lock(mutex_);
      if (done)
        filled_ = i + 1;
      else
        failed_ = done.error();
    }
    changed_.notify_all();
    if (!done) return;
  }
}

Expected<v1::Chunk*> ReadAhead::next() {
  std::unique_lock lock(mutex_);
  if (taken_ == indices_.size()) return nullptr;
  changed_.wait(lock, [this] { return filled_ > taken_ || failed_; });
  if (filled_ <= taken_) return tl::unexpected<Error>(*failed_);
  v1::Chunk* chunk = &ring_[taken_++ % kAhead];
  lock.unlock();
  changed_.notify_all();
  return chunk;
}

HashBeside::HashBeside(const UploadFile& file)
    : thread_([this, &file](const std::stop_token& stop) {
        auto hash = file.sha256(stop);
        if (!hash || hash->empty()) return;
        hash_ = std::move(*hash);
        ready_ = true;
      }) {}

}  // namespace tenter::client
