// SPDX-License-Identifier: GPL-3.0-or-later
// What an attempt has done, on disk, for the next attempt of the same specification.
//
//   const CheckpointFile file(input.checkpoints, input.spec_json, "starts.json");
//   std::optional<json> before = file.load();
//   file.save(done);                                       // replaces it whole
//
// A kill leaves the old or the new content. A file that is damaged, or of another specification, is
// as if there were none. Nothing fails: without a place, with a full disk, or above kMostBytes a
// later attempt just does more. Numbers survive to the last bit. One thread at a time.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace tenter::jobs {

class CheckpointFile {
 public:
  static constexpr std::size_t kMostBytes = 16u << 20;

  /// `folder` "": nothing is kept.
  CheckpointFile(std::filesystem::path folder, const std::string& spec_json, std::string name);

  std::optional<nlohmann::json> load() const;
  void save(const nlohmann::json& content) const;

 private:
  std::filesystem::path folder_;
  std::string spec_sha256_;
  std::string name_;
};

}  // namespace tenter::jobs
