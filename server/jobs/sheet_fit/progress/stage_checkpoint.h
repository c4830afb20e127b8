// SPDX-License-Identifier: GPL-3.0-or-later
// What a fit has done, on disk, so that a killed one goes on after its last finished stages.
//
//   StageCheckpoint checkpoint(input.checkpoints, input.spec_json);
//   std::optional<StagedResult> before = checkpoint.load();
//   checkpoint.save(result);                               // whenever stages have ended
//
// One file, replaced whole: a kill leaves the old or the new one. A file that is damaged, or of
// another specification, is as if there were none. Nothing fails: without a place, with a full
// disk, or above kMostBytes a later attempt just does more. One thread at a time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "server/estimation/staged/staged_fit.h"

namespace tenter::jobs {

class StageCheckpoint {
 public:
  static constexpr std::size_t kMostBytes = 16u << 20;

  /// `folder` "": nothing is kept.
  StageCheckpoint(std::filesystem::path folder, const std::string& spec_json);

  std::optional<estimation::StagedResult> load() const;
  void save(const estimation::StagedResult& result) const;

 private:
  std::filesystem::path folder_;
  std::string spec_sha256_;
};

}  // namespace tenter::jobs
