// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/progress/checkpoint_file.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/atomic_write.h"
#include "common/base/sha256.h"
#include "common/base/text_file.h"

namespace tenter::jobs {

using nlohmann::json;

CheckpointFile::CheckpointFile(std::filesystem::path folder, const std::string& spec_json,
                               std::string name)
    : folder_(std::move(folder)), spec_sha256_(sha256_hex(spec_json)), name_(std::move(name)) {}

std::optional<json> CheckpointFile::load() const {
  if (folder_.empty()) return std::nullopt;
  const auto text = read_text_file((folder_ / name_).string(), kMostBytes);
  if (!text) return std::nullopt;
  json document = json::parse(*text, nullptr, false);
  if (!document.is_object() || !document.contains("fit") ||
      document.value("spec_sha256", std::string()) != spec_sha256_)
    return std::nullopt;
  return std::move(document["fit"]);
}

void CheckpointFile::save(const json& content) const {
  if (folder_.empty()) return;
  const std::string text = json{{"spec_sha256", spec_sha256_}, {"fit", content}}.dump() + "\n";
  if (text.size() > kMostBytes) return;
  std::error_code ignored;
  std::filesystem::create_directories(folder_, ignored);
  [[maybe_unused]] const auto written =
      write_atomically((folder_ / name_).string(), text.data(), text.size());
}

}  // namespace tenter::jobs
