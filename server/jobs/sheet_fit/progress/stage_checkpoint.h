// SPDX-License-Identifier: GPL-3.0-or-later
// The finished stages of a fit, so that a killed one goes on after them (checkpoint_file.h).
//
//   StageCheckpoint checkpoint(input.checkpoints, input.spec_json);
//   std::optional<StagedResult> before = checkpoint.load();
//   checkpoint.save(result);                               // whenever stages have ended
//
// Within a stage nothing is kept: its frames come to rest within a tolerance from where the step
// before left them, with its factors, so a fit that goes on from parameters alone would end in
// other last digits. Of random starts each one that ended is kept (StartCheckpoint).
#pragma once

#include <vector>

#include "server/estimation/staged/staged_fit.h"
#include "server/estimation/staged/start/multi_start.h"
#include "server/jobs/sheet_fit/progress/checkpoint_file.h"

namespace tenter::jobs {

class StageCheckpoint {
 public:
  StageCheckpoint(std::filesystem::path folder, const std::string& spec_json)
      : file_(std::move(folder), spec_json, "stages.json") {}

  std::optional<estimation::StagedResult> load() const;
  void save(const estimation::StagedResult& result) const;

 private:
  CheckpointFile file_;
};

/// Outcomes of random starts, in the order of the starts.
class StartCheckpoint {
 public:
  StartCheckpoint(std::filesystem::path folder, const std::string& spec_json)
      : file_(std::move(folder), spec_json, "starts.json") {}

  /// None where there are none.
  std::vector<estimation::StartOutcome> load() const;
  void save(const std::vector<estimation::StartOutcome>& outcomes) const;

 private:
  CheckpointFile file_;
};

}  // namespace tenter::jobs
