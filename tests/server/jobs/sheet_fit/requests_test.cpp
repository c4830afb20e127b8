// SPDX-License-Identifier: GPL-3.0-or-later
// What a sheet's fit does on request after its stages, through the job as the worker calls it, and
// what the door lets in.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/file/capture_file.h"
#include "common/model/document.h"
#include "common/model/presets.h"
#include "common/report/html_report.h"
#include "common/report/text_report.h"
#include "server/jobs/fit_requests.h"
#include "server/jobs/results/run_job.h"
#include "server/jobs/sheet_fit/sheet_options.h"
#include "tests/server/jobs/sheet_fit/sheet_captures.h"

namespace tenter::jobs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json document_of(const model::Model& model) {
  return json::parse(model::write_model(model));
}

/// Pulls along weft and warp, and one along the weft that no stage sees.
class Requests : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "tenter-requests-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// A job on captures of this cloth.
  json specification(const model::Model& cloth) {
    json spec = {{"kind", "fit"},
                 {"options",
                  {{"staged", false},
                   {"resolution", 7},
                   {"grid", "equal"},
                   {"start", "model"},
                   {"held_out", {id_of(3)}}}}};
    int index = 0;
    for (const char* role : {"stretch_u", "stretch_v", "stretch_u"}) {
      testing::SheetCaptureOptions options;
      options.role = role;
      options.frames = 5;
      options.seed = static_cast<unsigned>(++index);
      options.sigma_N = 5e-4;
      options.reach = index == 3 ? 0.7 : 1.0;
      options.cloth = cloth;
      const fs::path path = folder_ / (std::to_string(index) + ".h5");
      EXPECT_TRUE(capture::write_capture(testing::sheet_capture(options), path.string()));
      captures_.emplace_back(id_of(index), path);
      // forces alone: a sheet that is pulled has more than one way to lie
      if (index < 3) spec["options"]["roles"][id_of(index)] = role;
      spec["captures"].push_back(id_of(index));
    }
    // from values that are not those of the captures; what bends is not seen in a pull
    model::Model start = cloth;
    for (model::Term& term : start.terms)
      for (model::Parameter& p : term.law.parameters) {
        p.fixed = term.strain.name.starts_with("bend");
        if (!p.fixed) p.value *= 1.2;
      }
    spec["model"] = document_of(start);
    return spec;
  }

  json run(const json& spec) {
    const JobInput input{spec.dump(), captures_, folder_ / std::to_string(++runs_), {}};
    fs::create_directories(input.staging);
    const auto done = run_job(input, [](const JobProgress&) {}, {});
    EXPECT_TRUE(done) << done.error().message;
    bytes_ = text_of(input.staging / "result.json");
    return json::parse(bytes_);
  }

  static std::string text_of(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  static std::string id_of(int index) {
    return std::string(63, 'a') + static_cast<char>('0' + index);
  }

  fs::path folder_;
  std::vector<std::pair<std::string, fs::path>> captures_;
  std::string bytes_;
  int runs_ = 0;
};

TEST_F(Requests, RandomStartsSayHowManyReachTheBestBasin) {
  json spec = specification(testing::true_cloth());
  spec["options"]["starts"] = 3;
  spec["options"]["seed"] = 7;
  const json result = run(spec);
  const json& starts = result["starts"];
  ASSERT_EQ(starts["outcomes"].size(), 4U);
  double before = 0.0;
  std::set<int> seen;
  for (const json& outcome : starts["outcomes"]) {
    seen.insert(outcome["start"].get<int>());
    if (outcome["cost"].is_null()) continue;
    EXPECT_GE(outcome["cost"].get<double>(), before);
    before = outcome["cost"].get<double>();
  }
  EXPECT_EQ(seen, (std::set<int>{0, 1, 2, 3}));
  // stretch has one basin, which the fit itself is in
  EXPECT_FALSE(starts["is_better"].get<bool>());
  EXPECT_GE(starts["in_best_basin"].get<int>(), 3);
  EXPECT_NEAR(starts["cost_of_fit"].get<double>(), starts["outcomes"][0]["cost"].get<double>(),
              0.01 * starts["cost_of_fit"].get<double>());
  EXPECT_GT(starts["cost_of_fit"].get<double>(), 1.0);
  const std::string first = bytes_;
  // stopped when some starts had ended: the next attempt goes on with the others
  std::stop_source stop;
  JobInput input{spec.dump(), captures_, folder_ / "stopped", folder_ / "kept"};
  fs::create_directories(input.staging);
  const auto stopped = run_job(
      input,
      [&](const JobProgress& p) {
        if (p.stage == "starts" && !p.detail.starts_with("0 of")) stop.request_stop();
      },
      stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, ErrorKind::cancelled);
  ASSERT_TRUE(fs::exists(folder_ / "kept/stages.json"));
  ASSERT_TRUE(fs::exists(folder_ / "kept/starts.json"));
  std::vector<std::string> told;
  ASSERT_TRUE(
      run_job(input, [&](const JobProgress& p) { told.push_back(p.stage + " " + p.detail); }, {}));
  for (const std::string& words : told) {
    EXPECT_NE(words, "starts 0 of 4");
    EXPECT_FALSE(words.starts_with("all frame")) << words;  // the one stage is done
  }
  EXPECT_EQ(text_of(input.staging / "result.json"), first);
  spec["options"]["seed"] = 8;
  EXPECT_NE(run(spec)["starts"]["outcomes"], starts["outcomes"]);
}

TEST_F(Requests, AnEnergyThatIsNotConvexBecomesSoEachWay) {
  // softer and softer: beyond the strains of the pulls, 0.04, its stress falls
  model::Model cloth = testing::true_cloth();
  model::Law& weft = cloth.terms[0].law;
  weft.name = "bspline_stiffness";
  weft.range_lo = 0.0;
  weft.range_hi = 0.08;
  weft.parameters = {weft.parameters[0], weft.parameters[0]};
  weft.parameters[0].name = "k1";
  weft.parameters[1].name = "k2";
  weft.parameters[0].value = 50.0;
  weft.parameters[1].value = 10.0;
  json spec = specification(cloth);
  spec["options"]["max_control_points"] = 2;
  const double free = run(spec)["fit"]["cost"].get<double>();
  EXPECT_TRUE(json::parse(bytes_)["convexity"].is_null());
  double afterwards = 0.0;
  for (const char* way : {"afterwards", "every_step", "by_construction"}) {
    spec["options"]["convex"] = way;
    const json convex = run(spec)["convexity"];
    EXPECT_EQ(convex["way"], way);
    EXPECT_FALSE(convex["was_convex"].get<bool>());
    EXPECT_EQ(convex["least"]["term"], "weft");
    EXPECT_LT(convex["least"]["eigenvalue"].get<double>(), -5.0);
    EXPECT_TRUE(convex["is_convex"].get<bool>()) << convex;
    const double cost = convex["cost_after"].get<double>();
    EXPECT_GT(cost, 1.05 * convex["cost_before"].get<double>());
    EXPECT_GT(cost, 1.05 * free);
    if (std::string(way) == "afterwards") afterwards = cost;
    if (std::string(way) == "every_step") {
      EXPECT_LT(cost, (1.0 + 1e-9) * afterwards);
    }
    const auto fitted =
        model::parse_model(json::parse(bytes_)["model"].dump(), "the result's model");
    ASSERT_TRUE(fitted) << fitted.error().message;
    EXPECT_EQ(fitted->terms[0].law.name,
              std::string(way) == "by_construction" ? "convex_spline" : "bspline_stiffness");
  }
}

TEST_F(Requests, AnEvenSheetGetsNoSampleAndALimitOutOfReachIsSaidToBe) {
  json spec = specification(testing::true_cloth());
  spec["options"]["samples"] = 1;
  const json samples = run(spec)["samples"];
  EXPECT_EQ(samples["message"], "");
  EXPECT_EQ(samples["positions_m"].size(), 16U);
  ASSERT_FALSE(samples["steps"].empty());
  EXPECT_TRUE(samples["released"].empty());
  EXPECT_FALSE(samples["steps"][0]["kept"].get<bool>());
  EXPECT_GT(samples["held_out_before"].get<double>(), 1.0);
  EXPECT_EQ(samples["held_out_before"], samples["held_out"]);

  spec["options"].erase("samples");
  spec["options"]["limits"] = true;
  spec["model"]["limits"] =
      json::array({{{"id", "lock"}, {"terms", {"weft", "warp"}}, {"energy_max", 1.0}}});
  const json result = run(spec);
  const json& limit = result["limit"];
  EXPECT_EQ(limit["id"], "lock");
  EXPECT_FALSE(limit["is_reached"].get<bool>());
  EXPECT_NE(limit["message"].get<std::string>().find("is never reached"), std::string::npos);
  // k eps^2 / 2 of the warp, and what the weft adds: 80 x 0.04^2 / 2
  EXPECT_NEAR(limit["energy_max"].get<double>(), 0.064, 0.02);
  EXPECT_EQ(result["model"]["limits"][0]["energy_max"]["value"], 1.0);
}

TEST_F(Requests, ALimitThatIsReachedComesOutWithinItsInterval) {
  testing::SheetCaptureOptions options;
  options.role = "hung_v";
  options.pull_N = 0.42;  // of 0.32 N at the limit, were the sheet linear
  const double truth = 0.5 * 80.0 * 0.04 * 0.04;
  options.cloth.limits = {{"lock", {"warp"}, truth, "J/m^2"}};
  const fs::path path = folder_ / "hung.h5";
  ASSERT_TRUE(capture::write_capture(testing::sheet_capture(options), path.string()));
  captures_.emplace_back(id_of(1), path);
  model::Model start = options.cloth;
  start.limits[0].energy_max = 1.7 * truth;
  for (model::Term& term : start.terms)
    for (model::Parameter& p : term.law.parameters) p.fixed = term.id != "warp";
  start.terms[1].law.parameters[0].value = 65.0;
  const json result = run({{"kind", "fit"},
                           {"captures", {id_of(1)}},
                           {"model", document_of(start)},
                           {"options",
                            {{"staged", false},
                             {"resolution", 7},
                             {"grid", "equal"},
                             {"start", "model"},
                             {"channels", "all"},
                             {"roles", {{id_of(1), "stretch_v"}}},
                             {"limits", true}}}});
  const json& limit = result["limit"];
  ASSERT_TRUE(limit["is_reached"].get<bool>()) << limit;
  const double found = limit["energy_max"].get<double>();
  const double error = limit["std_error"].get<double>();
  EXPECT_GT(error, 1e-5 * truth);
  EXPECT_LT(error, 0.05 * truth);
  EXPECT_NEAR(found, truth, 1.96 * error);
  EXPECT_GT(limit["cost_without"].get<double>(), 2.0 * limit["cost"].get<double>());
  EXPECT_GE(limit["active_frames"].get<int>(), 1);
  EXPECT_EQ(result["model"]["limits"][0]["energy_max"]["value"], limit["energy_max"]);
  const json& warp = result["model"]["terms"][1]["law"]["parameters"]["k"];
  EXPECT_NEAR(warp["value"].get<double>(), 80.0, 3.0 * warp["std_error"].get<double>());
  // the page and the text name it
  const std::string page = report::render_html(result.dump()).value();
  EXPECT_NE(page.find("<code>lock</code>"), std::string::npos);
  EXPECT_NE(page.find("the limit &quot;lock&quot; is reached in 2 frames"), std::string::npos);
  const std::string text = report::render_text(result.dump(), {.width = 1000}).value();
  EXPECT_NE(text.find(limit["message"].get<std::string>()), std::string::npos) << text;
}

TEST(FitRequests, WhatDoesNotGoTogetherIsRefusedAtTheDoorInOneSentence) {
  const json cloth = document_of(testing::true_cloth());
  json locking = cloth;
  locking["limits"] = json::array({{{"id", "lock"}, {"terms", json::array()}, {"energy_max", 1}}});
  const json unseen = {{"held_out", {"x"}}};
  const auto with = [&](const json& more) {
    json all = unseen;
    all.update(more);
    return all;
  };
  for (const json& good :
       {json::object(), json{{"starts", 5}, {"convex", "every_step"}},
        with({{"samples", 2}, {"convex", "by_construction"}}), json{{"limits", false}},
        json{{"hold_unseen", "start"}, {"without_grid_error", true}},
        with({{"samples", 0}, {"robust", "huber"}}), with({{"samples", 2}, {"robust", "none"}})})
    EXPECT_TRUE(check_fit_requests(cloth, good)) << good;
  EXPECT_TRUE(check_fit_requests(locking, {{"limits", true}, {"robust", "huber"}}));
  const struct {
    json model, options;
    std::string words;
  } cases[] = {
      {cloth, {{"samples", 2}}, "options.samples: needs a capture that is held out"},
      {cloth, with({{"samples", 2}, {"robust", "huber"}}),
       "options.samples and options.robust do not go together: samples are judged by squares"},
      {locking, with({{"samples", 2}}), "options.samples: samples are not made of a model with"},
      {cloth, {{"limits", true}}, "options.limits: the model has 0 energy limits"},
      {locking, {{"limits", true}, {"starts", 4}}, "options.limits and options.starts do not"},
      {cloth,
       {{"convex", "afterwards"}, {"profiles", true}},
       "options.convex=afterwards and options.profiles do not go together"},
      {cloth,
       {{"without_grid_error", true}, {"grid", "equal"}},
       "options.without_grid_error and options.grid=equal do not go together"},
      {document_of(model::preset("cloth_springs").value()),
       {{"without_grid_error", true}},
       "options.without_grid_error: the term \""},
      {cloth,
       {{"hold_unseen", 0}, {"staged", false}},
       "options.hold_unseen: only a fit in stages has one"},
      {document_of(model::preset("stvk_orthotropic").value()),
       {{"convex", "by_construction"}},
       "options.convex: the term \"coupling\" has the law \"bilinear\""}};
  for (const auto& [model, options, words] : cases) {
    const auto checked = check_fit_requests(model, options);
    ASSERT_FALSE(checked) << options;
    EXPECT_EQ(checked.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(checked.error().message.substr(0, words.size()), words);
  }
  EXPECT_FALSE(read_sheet_options({{"staged", false}, {"seed", 3}}, {"x"}));
  json curves = {{"staged", false}, {"keep_points", true}, {"knots", "data"}, {"frames", 30}};
  const auto taken = read_sheet_options(curves, {"x"});
  ASSERT_TRUE(taken) << taken.error().message;
  EXPECT_TRUE(taken->keep_points && taken->knots_from_data);
  EXPECT_EQ(options_json(*taken)["knots"], "data");
  EXPECT_EQ(options_json(*taken)["frames"], 30);
  curves.update(json{{"staged", true}, {"roles", {{"x", "stretch_u"}}}});
  const auto refused = read_sheet_options(curves, {"x"});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message.substr(0, 20), "options.keep_points:");
}

}  // namespace
}  // namespace tenter::jobs
