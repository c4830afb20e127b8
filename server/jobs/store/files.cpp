// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/store/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace tenter::jobs {

namespace fs = std::filesystem;

Error system_error(const fs::path& path, std::string_view doing, int error_number) {
  ErrorKind kind = ErrorKind::internal;
  if (error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG)
    kind = ErrorKind::no_space;
  if (error_number == ENOENT) kind = ErrorKind::not_found;
  return {kind,
          path.string() + ": " + std::string(doing) + " failed: " + std::strerror(error_number)};
}

namespace {
tl::unexpected<Error> failed(const fs::path& path, std::string_view doing) {
  return tl::unexpected<Error>(system_error(path, doing, errno));
}
}  // namespace

FileDescriptor::~FileDescriptor() {
  close();
}
FileDescriptor::FileDescriptor(FileDescriptor&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)) {}
FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    close();
    fd_ = std::exchange(other.fd_, -1);
  }
  return *this;
}
void FileDescriptor::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

Expected<FileDescriptor> open_file(const fs::path& path, int flags, unsigned mode) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  if (fd < 0) return failed(path, "opening");
  return FileDescriptor(fd);
}

Expected<void> make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) return tl::unexpected<Error>(system_error(path, "making the folder", error.value()));
  return {};
}

Expected<void> write_all(int fd, std::string_view bytes, const fs::path& named) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return failed(named, "writing");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

Expected<void> write_all_at(int fd, std::string_view bytes, std::uint64_t offset,
                            const fs::path& named) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return failed(named, "writing");
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
  return {};
}

Expected<void> sync_file(const fs::path& path) {
  auto file = open_file(path, O_RDONLY);
  if (!file) return tl::unexpected(file.error());
  if (::fsync(file->get()) != 0) return failed(path, "writing to disk");
  return {};
}

Expected<void> sync_folder(const fs::path& path) {
  auto folder = open_file(path, O_RDONLY | O_DIRECTORY);
  if (!folder) return tl::unexpected(folder.error());
  if (::fsync(folder->get()) != 0) return failed(path, "writing the folder to disk");
  return {};
}

Expected<void> rename_durably(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) return failed(to, "moving into place");
  return sync_folder(to.parent_path());
}

Expected<void> write_file_durably(const fs::path& path, std::string_view bytes) {
  fs::path beside = path;
  beside += ".new";
  const auto clean = [&beside](Error error) {
    ::unlink(beside.c_str());
    return tl::unexpected<Error>(std::move(error));
  };
  auto file = open_file(beside, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file) return clean(file.error());
  if (auto done = write_all(file->get(), bytes, path); !done) return clean(done.error());
  if (::fsync(file->get()) != 0) return clean(system_error(path, "writing to disk", errno));
  file->close();
  if (auto done = rename_durably(beside, path); !done) return clean(done.error());
  return {};
}

Expected<std::string> read_file(const fs::path& path, std::size_t limit_bytes) {
  auto file = open_file(path, O_RDONLY);
  if (!file) return tl::unexpected(file.error());
  std::string bytes;
  char piece[65536];
  for (;;) {
    const ssize_t got = ::read(file->get(), piece, sizeof piece);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return failed(path, "reading");
    if (got == 0) return bytes;
    if (bytes.size() + static_cast<std::size_t>(got) > limit_bytes) {
      return bad_input(path.string() + ": is larger than " + std::to_string(limit_bytes) +
                       " bytes");
    }
    bytes.append(piece, static_cast<std::size_t>(got));
  }
}

Expected<FileStamp> stamp_of(const fs::path& path) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return failed(path, "looking");
  const auto ns = [](const timespec& t) {
    return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  };
  return FileStamp{found.st_ino, static_cast<std::uint64_t>(found.st_size), ns(found.st_mtim),
                   ns(found.st_ctim)};
}

}  // namespace tenter::jobs
