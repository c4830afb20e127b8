// SPDX-License-Identifier: GPL-3.0-or-later
// A folder, CSV files and descriptions in it, and a job run on the captures that they make: as a
// user and the worker have it.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "common/capture/csv/csv_import.h"
#include "common/capture/file/capture_file.h"
#include "common/model/presets.h"
#include "server/jobs/results/run_job.h"

namespace tenter::jobs {

class FrictionJob : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "tenter-friction-job-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Imports and adds to the captures of the jobs to come.
  void import(const std::string& name, const std::string& csv, const std::string& description) {
    const auto path = [&](const char* extension) { return folder_ / (name + extension); };
    std::ofstream(path(".csv")) << csv;
    std::ofstream(path(".json")) << description;
    const auto capture = capture::import_csv(path(".csv").string(), path(".json").string());
    ASSERT_TRUE(capture) << capture.error().message;
    ASSERT_TRUE(capture::write_capture(*capture, path(".h5").string()));
    captures_.emplace_back(std::string(64, static_cast<char>('a' + captures_.size())), path(".h5"));
  }

  Expected<nlohmann::json> run(const nlohmann::json& options, const char* kind = "fit") {
    nlohmann::json spec;
    spec["kind"] = kind;
    spec["captures"] = nlohmann::json::array();
    for (const auto& [id, file] : captures_) spec["captures"].push_back(id);
    spec["model"] = nlohmann::json::parse(model::preset_json("stvk_diagonal").value());
    spec["options"] = options;
    JobInput input;
    input.spec_json = spec.dump();
    input.captures = captures_;
    input.staging = folder_ / "staging";
    std::filesystem::remove_all(input.staging);
    std::filesystem::create_directories(input.staging);
    stages_.clear();
    const auto done =
        run_job(input, [this](const JobProgress& p) { stages_.push_back(p.stage); }, {});
    if (!done) return tl::unexpected(done.error());
    EXPECT_TRUE(std::filesystem::exists(input.staging / "residuals.h5"));
    std::ostringstream text;
    text << std::ifstream(input.staging / "result.json").rdbuf();
    text_ = text.str();
    return nlohmann::json::parse(text_);
  }

  /// Why a job is refused; "done" where it is not.
  std::string refusal(const nlohmann::json& options, const char* kind = "fit") {
    const auto result = run(options, kind);
    return result ? "done" : result.error().message;
  }

  std::filesystem::path folder_;
  std::vector<std::pair<std::string, std::filesystem::path>> captures_;
  std::vector<std::string> stages_;  ///< of the progress of the last job
  std::string text_;                 ///< result.json of the last job
};

}  // namespace tenter::jobs
