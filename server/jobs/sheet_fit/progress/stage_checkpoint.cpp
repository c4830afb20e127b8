// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/progress/stage_checkpoint.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "server/jobs/sheet_fit/progress/stage_json.h"

namespace tenter::jobs {

std::optional<estimation::StagedResult> StageCheckpoint::load() const {
  const auto content = file_.load();
  if (!content) return std::nullopt;
  auto result = staged_from_json(*content);
  if (!result || result->stages.empty()) return std::nullopt;
  return std::move(*result);
}

void StageCheckpoint::save(const estimation::StagedResult& result) const {
  file_.save(to_json(result));
}

std::vector<estimation::StartOutcome> StartCheckpoint::load() const {
  const auto content = file_.load();
  if (!content) return {};
  auto outcomes = outcomes_from_json(*content);
  return outcomes ? std::move(*outcomes) : std::vector<estimation::StartOutcome>{};
}

void StartCheckpoint::save(const std::vector<estimation::StartOutcome>& outcomes) const {
  file_.save(to_json(outcomes));
}

}  // namespace tenter::jobs
