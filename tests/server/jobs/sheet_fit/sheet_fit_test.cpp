// SPDX-License-Identifier: GPL-3.0-or-later
// The job that fits a sheet, called as the worker calls it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "common/capture/file/capture_file.h"
#include "common/model/document.h"
#include "common/model/presets.h"
#include "common/report/html_report.h"
#include "common/report/residual_file.h"
#include "server/jobs/results/run_job.h"
#include "server/jobs/sheet_fit/progress/stage_checkpoint.h"
#include "server/jobs/sheet_fit/sheet_options.h"
#include "tests/server/jobs/sheet_fit/sheet_captures.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string id_of(int index) {
  return std::string(63, 'a') + static_cast<char>('0' + index);
}

class SheetJob : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (fs::temp_directory_path() / "tenter-sheet-job-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    int index = 0;
    for (const char* role : {"stretch_u", "stretch_v", "shear", "bend_u", "bend_v", "stretch_u"}) {
      testing::SheetCaptureOptions options;
      options.role = role;
      options.seed = static_cast<unsigned>(++index);
      options.sigma_N = 5e-4;
      options.reach = index == 6 ? 0.7 : 1.0;  // the last is for evaluation
      const fs::path path = folder_ / (std::to_string(index) + ".h5");
      ASSERT_TRUE(capture::write_capture(testing::sheet_capture(options), path.string()));
      captures_.emplace_back(id_of(index), path);
      spec_["captures"].push_back(id_of(index));
      spec_["options"]["roles"][id_of(index)] = index == 6 ? "evaluation" : role;
    }
    spec_["options"]["resolution"] = 7;
    spec_["options"]["grid"] = "equal";  // as they are made
    spec_["options"]["max_control_points"] = 2;
    spec_["kind"] = "fit";
    spec_["model"] = json::parse(model::preset_json("cloth_stvk_spline").value());
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  JobInput input(const std::string& name, const json& spec, const std::string& checkpoints) const {
    JobInput input{spec.dump(), captures_, folder_ / name,
                   checkpoints.empty() ? fs::path() : folder_ / checkpoints};
    fs::create_directories(input.staging);
    return input;
  }
  Expected<void> run(const std::string& name, const json& spec = spec_,
                     const std::string& checkpoints = "") {
    progress_.clear();
    return run_job(input(name, spec, checkpoints),
                   [this](const JobProgress& p) { progress_.push_back(p); }, {});
  }
  static std::string bytes(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(folder_ / file, std::ios::binary).rdbuf();
    return text.str();
  }

  static inline fs::path folder_;
  static inline std::vector<std::pair<std::string, fs::path>> captures_;
  static inline json spec_;
  std::vector<JobProgress> progress_;
};

TEST_F(SheetJob, FindsTheClothAndTellsAllThatItDid) {
  json spec = spec_;
  spec["model"] = json::parse(model::preset_json("cloth_stvk").value());
  const auto done = run("stvk", spec);
  ASSERT_TRUE(done) << done.error().message;
  const json result = json::parse(bytes("stvk/result.json"));
  EXPECT_EQ(result["schema"], "tenter.sheet_fit");
  const std::string page_checks = result["checklist"].dump();
  const double truth[] = {45.0, 80.0, 9.0, 4e-5, 6e-5, 5e-5};
  ASSERT_EQ(result["parameters"].size(), 6U);
  for (std::size_t k = 0; k < 6; ++k) {
    const json& p = result["parameters"][k];
    // strips that hang over a straight edge hardly tell diagonal bending: whatever became of it is
    // said
    if (p["name"] == "bend_diagonal.k") {
      const bool is_told = page_checks.find("bend_diagonal.k") != std::string::npos;
      EXPECT_TRUE(p["state"] == "free" || is_told) << p;
      continue;
    }
    EXPECT_EQ(p["state"], "free") << p["name"];
    EXPECT_NEAR(p["value"].get<double>(), truth[k], 0.05 * truth[k]) << p["name"];
    // five standard errors, which are themselves no larger than a tenth of the value
    const double error = p["std_error"].get<double>();
    EXPECT_LT(error, 0.1 * truth[k]) << p["name"];
    EXPECT_NEAR(p["value"].get<double>(), truth[k], 5.0 * error) << p["name"];
  }
  // the noise floor, and nothing below it, also of the capture that no stage saw
  for (const char* kind : {"fitted", "held_out"})
    for (const char* channel : {"force", "position"}) {
      const json& errors = result[kind][channel];
      EXPECT_LT(errors["after_sigmas"].get<double>(), 1.5) << kind << " " << channel;
      EXPECT_GT(errors["after_sigmas"].get<double>(), 0.4) << kind << " " << channel;
      // where a pulled sheet lies hardly hangs on its stiffness
      if (std::string(kind) == "fitted" || std::string(channel) == "force") {
        EXPECT_GT(errors["before_sigmas"].get<double>(), 3.0) << kind << " " << channel;
      }
    }
  ASSERT_EQ(result["captures"].size(), 6U);
  EXPECT_TRUE(result["captures"][5]["held_out"].get<bool>());
  EXPECT_TRUE(result["captures"][3]["force"].is_null());
  EXPECT_EQ(result["model"]["lineage"]["captures"].size(), 5U);
  EXPECT_GE(result["stages"].size(), 7U);
  EXPECT_EQ(result["stages"].back()["name"], "coupled");
  EXPECT_EQ(result["curves"].size(), 6U);
  EXPECT_EQ(result["curves"][0]["lo"].size(), result["curves"][0]["strain"].size());
  // pulled by 4 mm of 100 mm: Green strains up to 0.04
  EXPECT_NEAR(result["curves"][0]["reached"][1].get<double>(), 0.04, 0.012);
  EXPECT_GE(result["meshes"].size(), 6U);
  EXPECT_EQ(result["meshes"][0]["position_m"].size(), 49U);

  const std::string page = report::render_html(result.dump()).value();
  for (const char* part : {"id=\"curves\"", "id=\"loops\"", "id=\"sheets\"", "series ribbon",
                           "HELD OUT", "class=\"arrow\""})
    EXPECT_NE(page.find(part), std::string::npos) << part;

  const auto tables = report::read_residuals((folder_ / "stvk/residuals.h5").string());
  ASSERT_TRUE(tables) << tables.error().message;
  ASSERT_EQ(tables->size(), 4U);
  EXPECT_EQ((*tables)[0].channel, "moved");
  EXPECT_NEAR((*tables)[0].displacement_m.back(), 0.8 * 4e-3, 1e-9);
  EXPECT_EQ((*tables)[3].weight[0], 0.0);  // held out
  const auto vertices = report::read_vertex_residuals((folder_ / "stvk/residuals.h5").string(),
                                                      {.capture = id_of(4)});
  ASSERT_TRUE(vertices);
  ASSERT_EQ(vertices->size(), 1U);
  EXPECT_EQ(vertices->front().frame.size(), 5U);
}

/// Stages, the frame being solved, the values that are tried; never backwards.
void expect_live(const std::vector<JobProgress>& all) {
  std::set<std::string> stages;
  bool has_values = false;
  double fraction = 0.0;
  for (const JobProgress& p : all) {
    stages.insert(p.stage);
    has_values |= p.detail.find("frame ") == 0 && p.detail.find("; weft ") != std::string::npos;
    EXPECT_GE(p.fraction, fraction);
    fraction = p.fraction;
  }
  for (const char* stage : {"prepare", "shear", "coupled", "compare", "write"})
    EXPECT_TRUE(stages.contains(stage)) << stage;
  // they run side by side, and one of them is told of
  EXPECT_TRUE(stages.contains("stretch_u") || stages.contains("stretch_v"));
  EXPECT_TRUE(has_values);
}

TEST_F(SheetJob, GoesOnAfterItsLastStageWithTheSameBytes) {
  ASSERT_TRUE(run("whole"));
  expect_live(progress_);
  const std::string whole = bytes("whole/result.json");
  // stopped while a stage runs, as a cancelled or killed worker is
  std::stop_source stop;
  const auto stopped = run_job(
      input("part", spec_, "kept"),
      [&](const JobProgress& p) {
        if (p.stage == "bend_u" || p.stage == "bend_v") stop.request_stop();
      },
      stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, ErrorKind::cancelled);
  EXPECT_FALSE(fs::exists(folder_ / "part/result.json"));
  ASSERT_TRUE(fs::exists(folder_ / "kept/stages.json"));
  ASSERT_TRUE(run("resumed", spec_, "kept"));
  const auto was_told = [&] {
    for (const JobProgress& p : progress_)
      if (p.detail.find("stages were done by an earlier attempt") != std::string::npos) return true;
    return false;
  };
  EXPECT_TRUE(was_told());
  for (const JobProgress& p : progress_) EXPECT_NE(p.stage, "stretch_u");
  EXPECT_EQ(bytes("resumed/result.json"), whole);
  EXPECT_EQ(bytes("resumed/residuals.h5"), bytes("whole/residuals.h5"));

  // a torn file, or one of other work, is as none
  const std::string sound = bytes("kept/stages.json");
  ASSERT_GT(sound.size(), 1000U);
  StageCheckpoint other(folder_ / "kept", "another specification");
  EXPECT_FALSE(other.load());
  std::ofstream(folder_ / "kept/stages.json") << sound.substr(0, sound.size() / 2);
  EXPECT_FALSE(StageCheckpoint(folder_ / "kept", spec_.dump()).load());
  std::ofstream(folder_ / "kept/stages.json") << sound;
  EXPECT_TRUE(StageCheckpoint(folder_ / "kept", spec_.dump()).load());
}

TEST_F(SheetJob, BadOptionsAreRefusedByTheirPath) {
  const std::vector<std::string> ids = {id_of(1), id_of(2)};
  const json roles = {{id_of(1), "stretch_u"}, {id_of(2), "evaluation"}};
  EXPECT_TRUE(read_sheet_options({{"roles", roles}}, ids));
  EXPECT_TRUE(read_sheet_options({{"staged", false}}, ids));
  const struct {
    json options;
    std::string words;
  } cases[] = {
      {{{"resolution", 2}}, "options.resolution: must be a whole number from 3 to 201, not 2"},
      {{{"resolution", 9.5}}, "options.resolution: must be a whole number"},
      {{{"points", "all"}}, "options.points: must be a whole number"},
      {{{"start", "luck"}}, "options.start: must be one of equation_gap, model, not \"luck\""},
      {{{"staged", 1}}, "options.staged: must be true or false"},
      {{{"roles", {{id_of(1), "pull"}}}},
       "options.roles." + id_of(1) + ": must be one of stretch_u"},
      {{{"roles", {{"ffff", "shear"}}}}, "options.roles.ffff: is no capture of this job"},
      {{{"roles", {{id_of(1), "shear"}}}}, "options.roles: capture " + id_of(2).substr(0, 12)},
      {{{"held_out", {id_of(1), "x"}}}, "options.held_out[1]: is no capture of this job: \"x\""},
      {{{"held_out", ids}}, "options.held_out: no capture is left to fit to"},
      {{{"weights", {{id_of(1), -1}}}}, "options.weights." + id_of(1) + ": must be a number above"},
      {{{"robust", "l1"}}, "options.robust: must be one of none, huber, cauchy"},
      {{{"sigma_m", 0}}, "options.sigma_m: must be a number above zero"},
      {{{"leave_out", "runs"}}, "options.leave_out: no such option"}};
  for (const auto& [options, words] : cases) {
    const auto read = read_sheet_options(options, ids);
    ASSERT_FALSE(read) << options;
    EXPECT_EQ(read.error().message.substr(0, words.size()), words);
  }
  const json filled = options_json(read_sheet_options({{"roles", roles}}, ids).value());
  EXPECT_EQ(filled["start"], "equation_gap");
  EXPECT_EQ(filled["roles"], roles);
  EXPECT_EQ(filled["grid"], "graded");
}

TEST_F(SheetJob, OneStageForAllAndRefusals) {
  json spec = spec_;
  spec["model"] = json::parse(model::preset_json("cloth_stvk").value());
  spec["options"] = {{"staged", false},        {"resolution", 7},   {"grid", "equal"},
                     {"robust", "huber"},      {"channels", "all"}, {"points", 20},
                     {"held_out", {id_of(6)}}, {"profiles", true}};
  const auto done = run("at-once", spec);
  ASSERT_TRUE(done) << done.error().message;
  const json result = json::parse(bytes("at-once/result.json"));
  ASSERT_EQ(result["stages"].size(), 1U);
  EXPECT_NEAR(result["parameters"][0]["value"].get<double>(), 45.0, 2.0);
  EXPECT_LE(result["captures"][0]["points"].get<int>(), 20);
  // the profile of a stretch is no parabola's, but tells much the same
  EXPECT_EQ(result["options"]["profiles"], true);
  const json& weft = result["parameters"][0];
  ASSERT_TRUE(weft["profile"].is_object()) << weft;
  EXPECT_EQ(weft["profile"]["word"], "bounded");
  EXPECT_GT(weft["profile"]["fits"].get<int>(), 4);
  const double lo = weft["profile"]["lo"].get<double>(), hi = weft["profile"]["hi"].get<double>();
  EXPECT_LT(lo, weft["value"].get<double>());
  EXPECT_GT(hi, weft["value"].get<double>());
  EXPECT_GT(hi - lo, 2.0 * weft["std_error"].get<double>());
  EXPECT_LT(hi - lo, 40.0 * weft["std_error"].get<double>());

  spec["kind"] = "simulate";
  EXPECT_NE(run("refused", spec).error().message.find("captures: "), std::string::npos);
}

}  // namespace
}  // namespace tenter::jobs
