// SPDX-License-Identifier: Apache-2.0
#include "common/base/atomic_write.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace tenter {

namespace {

tl::unexpected<Error> system_error(const std::string& path, const char* doing, int code) {
  const bool full = code == ENOSPC || code == EDQUOT || code == EFBIG;
  const bool theirs = code == ENOENT || code == EACCES || code == ENOTDIR || code == EROFS ||
                      code == EISDIR || code == EPERM;
  const ErrorKind kind = full     ? ErrorKind::no_space
                         : theirs ? ErrorKind::bad_input
                                  : ErrorKind::internal;
  return fail(kind, path + ": " + doing + " failed: " + std::strerror(code) + ".");
}

bool write_all(int descriptor, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

/// Syncs a file or folder by name; a file's pages are its own, so any descriptor of it will do.
bool sync(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool ok = ::fsync(descriptor) == 0;
  const int code = errno;
  ::close(descriptor);
  errno = code;
  return ok;
}

}  // namespace

AtomicFile::AtomicFile(std::string path, std::string temporary)
    : path_(std::move(path)), temporary_(std::move(temporary)) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)), temporary_(std::exchange(other.temporary_, {})) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(temporary_, other.temporary_);
  return *this;
}

AtomicFile::~AtomicFile() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

tl::unexpected<Error> AtomicFile::error(const char* doing, int code) const {
  return system_error(path_, doing, code);
}

Expected<AtomicFile> AtomicFile::create(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0;; ++attempt) {
    std::string temporary =
        path + "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".part";
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      ::close(descriptor);
      return AtomicFile(path, std::move(temporary));
    }
    if (errno != EEXIST || attempt >= 100) return system_error(path, "creating the file", errno);
  }
}

Expected<void> AtomicFile::commit() {
  if (!sync(temporary_)) return error("syncing to disk", errno);
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) return error("renaming into place", errno);
  temporary_.clear();
  const std::string folder = std::filesystem::path(path_).parent_path().string();
  if (!sync(folder.empty() ? "." : folder)) return error("syncing the folder", errno);
  return {};
}

Expected<void> write_atomically(const std::string& path, const void* bytes, std::size_t size) {
  Expected<AtomicFile> file = AtomicFile::create(path);
  if (!file) return tl::unexpected(file.error());
  const int descriptor = ::open(file->temporary().c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return file->error("opening the file", errno);
  const bool written = write_all(descriptor, static_cast<const char*>(bytes), size);
  const int code = errno;
  const bool closed = ::close(descriptor) == 0;
  if (!written) return file->error("writing", code);
  if (!closed) return file->error("writing", errno);
  return file->commit();
}

}  // namespace tenter
