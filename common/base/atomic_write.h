// SPDX-License-Identifier: Apache-2.0
// Puts bytes at a path so that a reader sees the old file or the whole new one, also after a power
// cut: written to a temporary file in the same folder, synced, renamed over `path`, the folder
// synced. On failure nothing is left behind; a full disk is ErrorKind::no_space.
//
//   Expected<void> done = write_atomically(path, text.data(), text.size());
//
// or, where a library does the writing:
//
//   Expected<AtomicFile> file = AtomicFile::create(path);
//   ... the library writes to file->temporary() and closes it ...
//   Expected<void> done = file->commit();
#pragma once

#include <cstddef>
#include <string>

#include "common/base/error.h"

namespace tenter {

Expected<void> write_atomically(const std::string& path, const void* bytes, std::size_t size);

class AtomicFile {
 public:
  /// Makes the empty temporary file.
  static Expected<AtomicFile> create(const std::string& path);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  ~AtomicFile();  ///< removes the temporary file unless it was committed

  const std::string& temporary() const { return temporary_; }
  Expected<void> commit();

  /// The error for a failed system call on this file, from its errno.
  tl::unexpected<Error> error(const char* doing, int code) const;

 private:
  AtomicFile(std::string path, std::string temporary);
  std::string path_;
  std::string temporary_;  ///< empty once committed or moved from
};

}  // namespace tenter
