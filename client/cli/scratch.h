// SPDX-License-Identifier: Apache-2.0
// A folder of one's own that goes away with its object.
#pragma once

#include <filesystem>

#include "common/base/error.h"

namespace tenter::cli {

class ScratchFolder {
 public:
  static Expected<ScratchFolder> make();
  ScratchFolder(ScratchFolder&& other) noexcept;
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  ~ScratchFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(std::filesystem::path path);
  std::filesystem::path path_;
};

}  // namespace tenter::cli
