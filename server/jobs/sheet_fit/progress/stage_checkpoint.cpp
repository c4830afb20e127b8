// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/progress/stage_checkpoint.h"

#include <nlohmann/json.hpp>

#include "common/base/atomic_write.h"
#include "common/base/sha256.h"
#include "common/base/text_file.h"
#include "server/jobs/sheet_fit/progress/stage_json.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;

constexpr const char* kFile = "stages.json";

}  // namespace

StageCheckpoint::StageCheckpoint(std::filesystem::path folder, const std::string& spec_json)
    : folder_(std::move(folder)), spec_sha256_(sha256_hex(spec_json)) {}

std::optional<estimation::StagedResult> StageCheckpoint::load() const {
  if (folder_.empty()) return std::nullopt;
  const auto text = read_text_file((folder_ / kFile).string(), kMostBytes);
  if (!text) return std::nullopt;
  const json document = json::parse(*text, nullptr, false);
  if (!document.is_object() || !document.contains("fit") ||
      document.value("spec_sha256", std::string()) != spec_sha256_)
    return std::nullopt;
  auto result = staged_from_json(document["fit"]);
  if (!result || result->stages.empty()) return std::nullopt;
  return std::move(*result);
}

void StageCheckpoint::save(const estimation::StagedResult& result) const {
  if (folder_.empty()) return;
  const std::string text =
      json{{"spec_sha256", spec_sha256_}, {"fit", to_json(result)}}.dump() + "\n";
  if (text.size() > kMostBytes) return;
  std::error_code ignored;
  std::filesystem::create_directories(folder_, ignored);
  [[maybe_unused]] const auto written =
      write_atomically((folder_ / kFile).string(), text.data(), text.size());
}

}  // namespace tenter::jobs
