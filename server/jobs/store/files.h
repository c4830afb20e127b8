// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are either whole and on disk, or not there: the few system calls behind that, with
// clear errors.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/base/error.h"

namespace tenter::jobs {

/// "PATH: DOING failed: reason"; a full disk, an exceeded quota or file size is
/// ErrorKind::no_space.
Error system_error(const std::filesystem::path& path, std::string_view doing, int error_number);

/// Closes on leaving.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor();
  FileDescriptor(FileDescriptor&& other) noexcept;
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }
  void close();

 private:
  int fd_ = -1;
};

Expected<FileDescriptor> open_file(const std::filesystem::path& path, int flags,
                                   unsigned mode = 0640);
Expected<void> make_folder(const std::filesystem::path& path);  ///< with parents; existing is fine
Expected<void> write_all(int fd, std::string_view bytes, const std::filesystem::path& named);
Expected<void> write_all_at(int fd, std::string_view bytes, std::uint64_t offset,
                            const std::filesystem::path& named);
Expected<void> sync_file(const std::filesystem::path& path);
Expected<void> sync_folder(const std::filesystem::path& path);

/// Renames and syncs the folder of the destination. The source's content must have been synced.
Expected<void> rename_durably(const std::filesystem::path& from, const std::filesystem::path& to);
/// Writes beside the destination, syncs, renames.
Expected<void> write_file_durably(const std::filesystem::path& path, std::string_view bytes);
Expected<std::string> read_file(const std::filesystem::path& path, std::size_t limit_bytes);

/// What tells one content of a file from another without reading it.
struct FileStamp {
  std::uint64_t inode = 0, size = 0;
  std::int64_t modified_ns = 0, changed_ns = 0;
  bool operator==(const FileStamp&) const = default;
};
Expected<FileStamp> stamp_of(const std::filesystem::path& path);

}  // namespace tenter::jobs
