// SPDX-License-Identifier: GPL-3.0-or-later
// Captures of a sheet that is three times finer than the fit's grid, with and without the error of
// that grid; and diagonal bending held where it is not seen. Through the job as the worker calls
// it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/file/capture_file.h"
#include "common/model/document.h"
#include "common/report/html_report.h"
#include "common/report/residual_file.h"
#include "common/report/text_report.h"
#include "server/jobs/results/run_job.h"
#include "server/jobs/sheet_fit/sheet_options.h"
#include "tests/server/jobs/sheet_fit/sheet_captures.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string capture_id(int index) {
  return std::string(63, 'c') + static_cast<char>('0' + index);
}

class GridFreeJob : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-grid-free-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    int index = 0;
    for (const char* role : {"stretch_u", "stretch_v", "shear", "bend_u", "bend_v", "shear"}) {
      testing::SheetCaptureOptions options;
      options.role = role;
      options.nodes = 25;
      options.frames = 2;
      options.sigma_N = 1e-4;
      options.seed = static_cast<unsigned>(++index);
      options.reach = index == 6 ? 0.7 : 1.0;  // the last is for evaluation
      const fs::path path = folder_ / (std::to_string(index) + ".h5");
      ASSERT_TRUE(capture::write_capture(testing::sheet_capture(options), path.string()));
      captures_.emplace_back(capture_id(index), path);
      spec_["captures"].push_back(capture_id(index));
      spec_["options"]["roles"][capture_id(index)] = index == 6 ? "evaluation" : role;
    }
    model::Model start = testing::true_cloth();
    for (model::Term& term : start.terms) term.law.parameters[0].value *= 1.3;
    spec_["options"]["resolution"] = 9;
    spec_["options"]["points"] = 60;
    spec_["kind"] = "fit";
    spec_["model"] = json::parse(model::write_model(start));
  }
  void TearDown() override { fs::remove_all(folder_); }

  json run(const std::string& name) {
    const JobInput input{spec_.dump(), captures_, folder_ / name, {}};
    fs::create_directories(input.staging);
    const auto done = run_job(input, [](const JobProgress&) {}, {});
    EXPECT_TRUE(done) << (done ? "" : done.error().message);
    if (!done) return {};
    return json::parse(std::ifstream(input.staging / "result.json"));
  }
  std::vector<report::ResidualTable> forces(const std::string& name) const {
    return report::read_residuals((folder_ / name / "residuals.h5").string()).value();
  }

  fs::path folder_;
  std::vector<std::pair<std::string, fs::path>> captures_;
  json spec_;
};

const json& parameter(const json& result, const std::string& name) {
  for (const json& p : result["parameters"])
    if (p["name"] == name) return p;
  throw std::runtime_error(name);
}

bool is_told(const json& result, const std::string& what, const std::string& why) {
  for (const json& entry : result["checklist"])
    if (entry["what"].get<std::string>() == what &&
        entry["why"].get<std::string>().find(why) != std::string::npos)
      return true;
  return false;
}

TEST_F(GridFreeJob, FindsTheClothsShearAndTellsWhatWasTakenOff) {
  spec_["options"]["hold_unseen"] = 5e-5;
  const json as_it_is = run("as-it-is");
  EXPECT_TRUE(as_it_is["grid_error"].is_null());
  spec_["options"]["without_grid_error"] = true;
  const json result = run("without");
  const auto off = [](const json& of) {
    return std::abs(parameter(of, "shear.k")["value"].get<double>() / 9.0 - 1.0);
  };
  EXPECT_GT(off(as_it_is), 0.03);
  EXPECT_LT(off(result), 0.6 * off(as_it_is));
  // what no stage saw is met to its noise all the same, by what is not the grid's
  const double missed = result["held_out"]["force"]["after_sigmas"].get<double>();
  EXPECT_LT(missed, 1.5);
  EXPECT_GT(missed, 0.1);

  const json& grid = result["grid_error"];
  EXPECT_TRUE(grid["settled"].get<bool>());
  ASSERT_EQ(grid["captures"].size(), 6U);
  const json& shear = grid["captures"][2];
  EXPECT_EQ(shear["id"], capture_id(3));
  EXPECT_EQ(shear["order"], 1.7);
  EXPECT_EQ(grid["captures"][3]["order"], 2.0);  // over the table's edge
  EXPECT_TRUE(grid["captures"][3]["force"].is_null());
  EXPECT_GT(shear["force"]["sigmas"].get<double>(), 3.0);
  EXPECT_EQ(shear["frames_without"], 0);
  // the stages once more, then all curves together
  EXPECT_EQ(result["stages"].size(),
            2 * as_it_is["stages"].size() + grid["rounds"].get<std::size_t>() - 1);
  EXPECT_EQ(result["stages"].back()["done"], true);
  EXPECT_TRUE(is_told(result, "The grid's error was taken off", "settled after"));

  // twist, which the strips do not tell, is where it was asked to be
  const json& diagonal = parameter(result, "bend_diagonal.k");
  EXPECT_TRUE(diagonal["held"].get<bool>()) << result["stages"];
  EXPECT_EQ(diagonal["value"], 5e-5);
  EXPECT_EQ(diagonal["state"], "fixed");
  EXPECT_TRUE(diagonal["interval"].is_null());
  EXPECT_FALSE(parameter(result, "bend_weft.k")["held"].get<bool>());
  EXPECT_TRUE(is_told(result, "held: bend_diagonal.k", "the captures do not tell it"));

  // readings stay what was read
  const auto before = forces("as-it-is"), after = forces("without");
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < after.size(); ++k) {
    EXPECT_EQ(after[k].measured, before[k].measured);
    EXPECT_EQ(after[k].sigma, before[k].sigma);
    EXPECT_NE(after[k].predicted_extended, before[k].predicted_extended);
  }
  const std::string page = report::render_html(result.dump()).value();
  for (const char* words : {"<section id=\"grid-error\"", "held: the captures do not tell it"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  EXPECT_NE(report::render_text(result.dump()).value().find("taken off: up to "),
            std::string::npos);
}

TEST(GridFreeOptions, HoldUnseenIsAWordOrANumber) {
  const std::vector<std::string> ids = {capture_id(1)};
  const json roles = {{capture_id(1), "shear"}};
  const auto read = [&](const json& value) {
    return read_sheet_options({{"roles", roles}, {"hold_unseen", value}}, ids);
  };
  EXPECT_EQ(options_json(read(nullptr).value())["hold_unseen"], "stand_in");
  for (const json& value : {json("none"), json("stand_in"), json("start"), json(2.5e-5), json(0)})
    EXPECT_EQ(options_json(read(value).value())["hold_unseen"], value);
  const auto word = read("luck");
  ASSERT_FALSE(word);
  EXPECT_NE(word.error().message.find("options.hold_unseen: must be one of none, stand_in, start"),
            std::string::npos);
  const auto below = read(-1e-5);
  ASSERT_FALSE(below);
  EXPECT_NE(below.error().message.find("options.hold_unseen: must not be below zero"),
            std::string::npos);
}

}  // namespace
}  // namespace tenter::jobs
