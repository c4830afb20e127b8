// SPDX-License-Identifier: Apache-2.0
// The rest of a sheet between clamps: places in the material read from taut frames, slack frames
// named, and runs taken apart so that some can be held out.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/capture/run_selection.h"
#include "common/capture/sheet_import/sheet_import.h"
#include "common/capture/sheet_import/sheet_rest.h"
#include "common/capture/show.h"
#include "tests/common/capture/sheet/support.h"
#include "tests/common/capture/support.h"

namespace tenter::capture {
namespace {

using nlohmann::json;
using test::bytes_of;
using test::message_of;
using test::put_file;
using test::small_sheet_capture;
using test::TempFolder;

constexpr double kWide = 60.0, kLong = 40.0;  // mm, at rest

/// A pin at (u, v) of a sheet that hangs sagging in frame 1 of a run, half as long again in frame
/// 5, the clamps at `left` in the picture; in mm, y downwards.
std::string row(int run, int frame, double stretch, double left, double sag) {
  const auto place = [&](double u, double v) {
    return "," + std::to_string(left + u + sag) + "," + std::to_string(3.0 + stretch * v - sag);
  };
  return std::to_string(run) + "," + std::to_string(frame) + "," + std::to_string(stretch) +
         place(12.5, 30.0) + place(48.0, 10.0) + place(30.0, 0.0) + place(28.0, kLong) + "\n";
}

const std::string kPulls = "run,frame,force_N,a_x,a_y,b_x,b_y,top_x,top_y,bottom_x,bottom_y\n" +
                           row(1, 1, 1.0, 5.0, 2.5) + row(1, 5, 1.5, 5.0, 0.0) +
                           row(1, 9, 2.0, 5.0, 0.0) + row(2, 1, 1.0, 7.0, -4.0) +
                           row(2, 5, 1.5, 7.0, 0.0) + row(2, 9, 1.9, 7.0, 0.0);

json knit() {
  return json::parse(R"({
    "kind": "deforming_sheet", "title": "A knit", "specimen": {"name": "A", "material": "knit"},
    "protocol": {"name": "pull", "history": "continues", "repeats": true},
    "provenance": {"source": "a test"},
    "positions": {"unit": "mm", "sigma": 0.2, "material": "rest",
      "columns": {"run": "run", "frame": "frame"}, "points": [
        {"name": "a", "columns": {"x": "a_x", "y": "a_y"}},
        {"name": "b", "columns": {"x": "b_x", "y": "b_y"}}]},
    "outline": {"unit": "mm", "box": [[0, 0], [60, 40]]},
    "rest": {"clips": ["top", "bottom"], "slack_below": {"value": 4.5, "unit": "cm"},
             "read_at": {"value": 60.5, "unit": "mm"}},
    "clips": [
      {"id": "top", "role": "prescribed", "grip": {"unit": "mm", "position": [-30, 0, 0]},
       "region": {"unit": "mm", "polygon": [[0, 0], [60, 0]]}, "pose": {"unit": "mm",
         "columns": {"run": "run", "frame": "frame", "x": "top_x", "y": "top_y"}}},
      {"id": "bottom", "role": "prescribed", "grip": {"unit": "mm", "position": [-28, -40, 0]},
       "region": {"unit": "mm", "polygon": [[0, 40], [60, 40]]}, "pose": {"unit": "mm",
         "columns": {"run": "run", "frame": "frame", "x": "bottom_x", "y": "bottom_y"}}}],
    "cords": [{"id": "gauge", "clip": "bottom", "direction": [0, 1, 0], "tension": {"unit": "N",
      "columns": {"run": "run", "frame": "frame", "tension": "force_N"}}}],
    "gravity_m_s2": [0, 0, 0]})");
}

Expected<Capture> import_knit(const json& description) {
  const TempFolder folder;
  put_file(folder.path("knit.json"), description.dump());
  put_file(folder.path("knit.csv"), kPulls);
  auto capture = import_sheet(folder.path("knit.json"), folder.path("knit.csv"));
  if (capture) return capture;
  const std::string message = capture.error().message;
  return fail(capture.error().kind, message.substr(message.rfind('/') + 1));
}

TEST(SheetRest, PlacesAreThoseOfATautFrame) {
  const auto capture = import_knit(knit());
  ASSERT_TRUE(capture) << message_of(capture);
  const Sheet& sheet = *capture->sheet;
  EXPECT_NEAR(sheet.material_m[0][0], 0.0125, 1e-9);
  EXPECT_NEAR(sheet.material_m[0][1], 0.030, 1e-9);
  EXPECT_NEAR(sheet.material_m[1][0], 0.048, 1e-9);
  EXPECT_NEAR(sheet.material_m[1][1], 0.010, 1e-9);
  std::vector<bool> slack;
  for (std::size_t f = 0; f < capture->frame_count(); ++f) slack.push_back(sheet.is_slack(f));
  EXPECT_EQ(slack, (std::vector<bool>{true, false, false, true, false, false}));
  EXPECT_NE(show_text(*capture).find(
                "slack       where top and bottom are closer than 45 mm: 2 frames\n"),
            std::string::npos)
      << show_text(*capture);
  json first = knit();
  first["positions"]["material"] = "first_frame";
  const auto sagging = import_knit(first);
  ASSERT_TRUE(sagging) << message_of(sagging);
  EXPECT_GT(std::abs(sagging->sheet->material_m[0][1] - 0.030), 2e-4);
}

TEST(SheetRest, PlacesTurnWithTheClips) {
  Capture capture = small_sheet_capture();
  Sheet& sheet = *capture.sheet;
  sheet.may_be_missing = false;
  sheet.clips[1].vertices.clear();
  sheet.clips[0].region_m = {{0.0, 0.0}, {0.0, 0.1}};
  sheet.clips[1].region_m = {{0.1, 0.0}, {0.1, 0.1}};
  sheet.clips[1].grip = {};
  const std::vector<Vec2> truth = sheet.material_m;
  const double angle = 0.7, stretch = 1.3;
  const Quaternion turn = {std::cos(angle / 2), 0.0, 0.0, std::sin(angle / 2)};
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const double x = stretch * truth[k][0], y = truth[k][1];
      sheet.position_m[sheet.at(f, k)] = 0.4 + x * std::cos(angle) - y * std::sin(angle);
      sheet.position_m[sheet.at(f, k) + 1] = x * std::sin(angle) + y * std::cos(angle);
      sheet.position_m[sheet.at(f, k) + 2] = 0.0;
    }
    const double beyond = 0.1 * (stretch - 1.0);  // of where the grip has the second clip's edge
    sheet.clips[0].pose[f] = {{0.4, 0.0, 0.0}, turn};
    sheet.clips[1].pose[f] = {{0.4 + beyond * std::cos(angle), beyond * std::sin(angle), 0.0},
                              turn};
  }
  RestSpec rest;
  rest.clips = {"fixed", "moved"};
  rest.read_at_m = 0.03;
  const auto places = places_at_rest(capture, rest);
  ASSERT_TRUE(places) << message_of(places);
  for (std::size_t k = 0; k < truth.size(); ++k)
    for (std::size_t c = 0; c < 2; ++c) EXPECT_NEAR((*places)[k][c], truth[k][c], 1e-12) << k;
}

TEST(SheetRest, SaysWhatIsMissing) {
  const auto complaint = [](const char* patch) {
    json description = knit();
    description.merge_patch(json::parse(patch));
    return message_of(import_knit(description));
  };
  EXPECT_EQ(complaint("{}"), "");
  EXPECT_EQ(complaint(R"({"rest": {"read_at": null}})"),
            "knit.json: rest.read_at is missing: it says where places in the material are read.");
  EXPECT_EQ(
      complaint(R"({"rest": {"read_at": {"value": 300, "unit": "mm"}}})"),
      "knit.json: rest.read_at: in run 1 clips \"top\" and \"bottom\" are never nearly so far "
      "apart.");
  EXPECT_EQ(complaint(R"({"rest": {"runs": [2, 3]}})"), "knit.json: rest.runs: there is no run 3.");
  EXPECT_EQ(complaint(R"({"rest": {"clips": ["top", "left"]}})"),
            "knit.json: rest.clips: there is no clip \"left\".");
  EXPECT_EQ(complaint(R"({"rest": {"slack_below": {"value": 0, "unit": "mm"}}})"),
            "knit.json: rest.slack_below must be a length above zero.");
  EXPECT_EQ(complaint(R"({"positions": {"material": "last_frame"}})"),
            "knit.json: positions.material must be \"first_frame\" or \"rest\".");
}

TEST(RunSelection, KeepsWhatBelongsToTheRuns) {
  const Capture capture = small_sheet_capture();
  const auto second = with_runs(capture, {5});
  ASSERT_TRUE(second) << message_of(second);
  EXPECT_EQ(second->runs.size(), 1U);
  EXPECT_EQ(second->runs[0].number, 5);
  EXPECT_EQ(second->title, "A sheet, run 5");
  EXPECT_EQ(second->run, (std::vector<int>{0, 0}));
  EXPECT_EQ(second->frame, (std::vector<int>{1, 7}));
  EXPECT_EQ(second->time_s, (std::vector<double>{0.0, 1.0 / 3.0}));
  const Sheet& sheet = *second->sheet;
  EXPECT_EQ(sheet.position_m.size(), capture.sheet->position_m.size() / 2);
  EXPECT_EQ(sheet.position_m[sheet.at(1, 8)], capture.sheet->position_m[sheet.at(3, 8)]);
  EXPECT_EQ(sheet.clips[1].pose[0].position_m[0], 0.002);
  EXPECT_EQ(sheet.cords[0].tension_N[1], 0.4);
  EXPECT_EQ(sheet.cords[0].direction[1], capture.sheet->cords[0].direction[3]);
  EXPECT_EQ(sheet.supports[0].edge_m, (std::vector<double>{0.02, 0.03}));
  EXPECT_EQ(bytes_of(*with_runs(capture, {5, 2})), bytes_of(capture));
  EXPECT_EQ(message_of(with_runs(capture, {2, 3})), "there is no run 3, only 2, 5");
}

}  // namespace
}  // namespace tenter::capture
