// SPDX-License-Identifier: Apache-2.0
#include "common/base/atomic_write.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace tenter {

namespace {

tl::unexpected<Error> system_error(const std::string& path, const char* doing, int code) {
  const bool full = code == ENOSPC || code == EDQUOT;
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

/// A new file beside `path`, under a name that nobody else in this or another process takes.
int create_beside(const std::string& path, std::string* temporary) {
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    *temporary =
        path + "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".part";
    const int descriptor =
        ::open(temporary->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
  }
  return -1;
}

}  // namespace

Expected<void> write_atomically(const std::string& path, const void* bytes, std::size_t size) {
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  std::string temporary;
  const int descriptor = create_beside(path, &temporary);
  if (descriptor < 0) return system_error(path, "creating the file", errno);

  const char* doing = "writing";
  bool ok = write_all(descriptor, static_cast<const char*>(bytes), size);
  if (ok) {
    doing = "syncing to disk";
    ok = ::fsync(descriptor) == 0;
  }
  int code = errno;
  if (::close(descriptor) != 0 && ok) {
    ok = false;
    code = errno;
  }
  if (ok) {
    doing = "renaming into place";
    ok = ::rename(temporary.c_str(), path.c_str()) == 0;
    code = errno;
  }
  if (!ok) {
    ::unlink(temporary.c_str());
    return system_error(path, doing, code);
  }
  const int directory = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory >= 0) {
    ::fsync(directory);
    ::close(directory);
  }
  return {};
}

}  // namespace tenter
