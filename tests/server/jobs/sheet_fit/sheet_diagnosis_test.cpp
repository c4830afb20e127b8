// SPDX-License-Identifier: GPL-3.0-or-later
// The job that diagnoses a sheet, called as the worker calls it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/capture/file/capture_file.h"
#include "common/model/catalogue.h"
#include "common/model/presets.h"
#include "common/report/html_report.h"
#include "server/jobs/results/run_job.h"
#include "tests/server/jobs/sheet_fit/sheet_captures.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Captures of a cloth whose warp stiffens, diagnosed with one whose stiffness is constant; the
/// shear is held out.
class SheetDiagnosisJob : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-sheet-diagnosis-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    testing::SheetCaptureOptions options;
    model::Law& warp = options.cloth.terms[1].law;
    warp.name = "convex_spline";
    warp.range_hi = 0.1;
    warp.parameters = model::default_parameters(*model::find_law("convex_spline"), 4);
    for (std::size_t k = 0; k < 4; ++k)
      warp.parameters[k].value = 60.0 + 60.0 * static_cast<double>(k);
    options.frames = 8;
    for (const char* role : {"stretch_u", "stretch_v", "shear"}) {
      options.role = role;
      ++options.seed;
      const fs::path path = folder_ / (std::string(role) + ".h5");
      ASSERT_TRUE(capture::write_capture(testing::sheet_capture(options), path.string()));
      captures_.emplace_back(std::string(63, 'b') + static_cast<char>('0' + options.seed), path);
      spec_["captures"].push_back(captures_.back().first);
    }
    spec_["kind"] = "diagnose";
    spec_["model"] = json::parse(model::preset_json("cloth_stvk").value());
    spec_["options"] = {{"resolution", 7},
                        {"grid", "equal"},
                        {"null_twins", 300},
                        {"held_out", json::array({captures_.back().first})}};
  }
  void TearDown() override { fs::remove_all(folder_); }

  Expected<void> run(const std::string& name) {
    const JobInput input{spec_.dump(), captures_, folder_ / name, {}};
    fs::create_directories(input.staging);
    return run_job(input, [this](const JobProgress& p) { stages_.push_back(p.stage); }, {});
  }
  json result(const std::string& name) const {
    return json::parse(std::ifstream(folder_ / name / "result.json"));
  }

  fs::path folder_;
  std::vector<std::pair<std::string, fs::path>> captures_;
  json spec_;
  std::vector<std::string> stages_;
};

TEST_F(SheetDiagnosisJob, NamesTheCauseAndShowsIt) {
  const auto done = run("job");
  ASSERT_TRUE(done) << done.error().message;
  const json found = result("job");
  EXPECT_EQ(found["schema"], "tenter.result");
  EXPECT_EQ(found["kind"], "diagnose");
  const json& verdict = found["verdicts"].at(0);
  // one pull up of eight frames hardly tells a warp that stiffens from a cell that errs
  const std::string kind = verdict["verdict"];
  EXPECT_TRUE(kind == "NAMED" || kind == "AMBIGUOUS") << verdict.dump(1) << found["path"].dump(1);
  EXPECT_EQ(verdict["effect"], "nonlinear_stiffness") << verdict.dump(1);
  EXPECT_LE(verdict["alternatives"].size(), 2U) << verdict.dump(1);
  EXPECT_GT(verdict["size"].get<double>(), 0.01);
  EXPECT_LT(found["error_after"].get<double>(), 0.8 * found["error_before"].get<double>());
  EXPECT_EQ(found["model"]["lineage"]["added"], json::array({"nonlinear_stiffness"}));
  EXPECT_EQ(found["held_out_kind"], "captures");
  ASSERT_EQ(found["captures"].size(), 3U);
  EXPECT_TRUE(found["captures"][2]["held_out"].get<bool>());
  EXPECT_FALSE(found["figures"].empty());
  EXPECT_FALSE(found["meshes"].empty());
  EXPECT_FALSE(found["structure"]["before"].empty());
  EXPECT_TRUE(fs::exists(folder_ / "job" / "residuals.h5"));
  EXPECT_NE(std::find(stages_.begin(), stages_.end(), "screen"), stages_.end());
  const auto page = report::render_html(found.dump());
  ASSERT_TRUE(page);
  for (const char* part : {"id=\"sheets\"", "svg class=\"mesh\"", "id=\"screen\"", "id=\"loops\""})
    EXPECT_NE(page->find(part), std::string::npos) << part;
}

TEST_F(SheetDiagnosisJob, TakesWhatReadingsShowWhereCapturesStateNoNoise) {
  for (const auto& [id, path] : captures_) {
    auto capture = capture::read_capture(path.string());
    ASSERT_TRUE(capture) << capture.error().message;
    capture->sheet->sigma_m = 0.0;
    capture->sheet->sigma_per_vertex_m.clear();
    for (capture::CordTrack& cord : capture->sheet->cords) cord.sigma_N = 0.0;
    fs::remove(path);
    ASSERT_TRUE(capture::write_capture(*capture, path.string()));
  }
  const auto done = run("job");
  ASSERT_TRUE(done) << done.error().message;
  const json found = result("job");
  // eight frames of noise that nobody knows: the cause, or a group that holds it
  const json& verdict = found["verdicts"].at(0);
  json group = verdict["alternatives"];
  group.push_back(verdict["effect"]);
  EXPECT_LE(group.size(), 3U);
  EXPECT_NE(std::ranges::find(group, "nonlinear_stiffness"), group.end()) << verdict.dump(1);
  EXPECT_NE(found["checklist"].dump().find("guessed"), std::string::npos)
      << found["checklist"].dump(1);
}

TEST_F(SheetDiagnosisJob, TriesNoOthersThanAskedFor) {
  spec_["options"]["effects"] = json::array({"poisson_coupling"});
  spec_["options"]["continues"] = {{"job", "7"}, {"said", json::array()}};
  const auto done = run("job");
  ASSERT_TRUE(done) << done.error().message;
  const json found = result("job");
  for (const json& verdict : found["verdicts"])
    EXPECT_NE(verdict["effect"], "nonlinear_stiffness") << verdict.dump(1);
  bool is_said = false;
  for (const json& row : found["screen"])
    is_said |= row["effect"] == "nonlinear_stiffness" && row["status"] == "not asked for";
  EXPECT_TRUE(is_said) << found["screen"].dump(1);
  EXPECT_EQ(found["continues"]["job"], "7");
}

TEST_F(SheetDiagnosisJob, RefusesWhatItDoesNotKnow) {
  spec_["options"]["resolutoin"] = 9;
  const auto done = run("job");
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("options.resolutoin: no such option"), std::string::npos)
      << done.error().message;
  spec_["options"].erase("resolutoin");
  spec_["options"]["rig_N"] = -1;
  const auto limited = run("job");
  ASSERT_FALSE(limited);
  EXPECT_NE(limited.error().message.find("options.rig_N: must be a number above zero"),
            std::string::npos)
      << limited.error().message;
}

}  // namespace
}  // namespace tenter::jobs
