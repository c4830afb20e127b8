// SPDX-License-Identifier: Apache-2.0
#include "client/cli/scratch.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

namespace tenter::cli {

Expected<ScratchFolder> ScratchFolder::make() {
  std::error_code failed;
  const std::filesystem::path parent = std::filesystem::temp_directory_path(failed);
  if (failed)
    return fail(ErrorKind::no_space, "there is no folder for temporary files: " + failed.message());
  std::string name = (parent / "tenter-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    return fail(ErrorKind::no_space, "no temporary folder can be made in " + parent.string() +
                                         ": " + std::strerror(errno));
  return ScratchFolder(name);
}

ScratchFolder::ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}
ScratchFolder::ScratchFolder(ScratchFolder&& other) noexcept : path_(std::move(other.path_)) {
  other.path_.clear();
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace tenter::cli
