// SPDX-License-Identifier: Apache-2.0
// Sheets from tables and back: an export comes back to the bit, tables of laboratories become SI,
// and what cannot be understood is said with file, line and column.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/capture/sheet/sheet_export.h"
#include "common/capture/sheet_import/sheet_import.h"
#include "common/capture/show.h"
#include "tests/common/capture/sheet/support.h"
#include "tests/common/capture/support.h"

namespace tenter::capture {
namespace {

using nlohmann::json;
using test::bytes_of;
using test::get_file;
using test::message_of;
using test::put_file;
using test::small_sheet_capture;
using test::TempFolder;

void expect_round_trip(const Capture& capture) {
  const TempFolder folder;
  const auto written = export_sheet(capture, folder.path("pull.json"));
  ASSERT_TRUE(written) << message_of(written);
  EXPECT_EQ(folder.file_count(), written->size());
  const auto read = import_sheet(folder.path("pull.json"));
  ASSERT_TRUE(read) << message_of(read);
  EXPECT_EQ(bytes_of(*read), bytes_of(capture));
}

TEST(SheetImport, AnExportComesBackToTheBit) {
  expect_round_trip(small_sheet_capture());
  Capture points = small_sheet_capture();
  points.sheet->triangles.clear();
  points.sheet->vertex_name = {"a", "b", "c", "d", "e", "f", "g", "h", "i"};
  points.sheet->coordinates = 2;
  points.sheet->position_m.resize(4 * 9 * 2);
  points.sheet->clips.pop_back();
  points.sheet->cords.clear();
  points.sheet->supports.clear();
  points.sheet->slack.reset();
  expect_round_trip(points);
}

TEST(SheetImport, AnExportReplacesNothingUnasked) {
  const TempFolder folder;
  put_file(folder.path("pull_clips.csv"), "mine");
  const auto written = export_sheet(small_sheet_capture(), folder.path("pull.json"));
  EXPECT_EQ(message_of(written), folder.path("pull_clips.csv") + ": exists; --force replaces it");
  EXPECT_EQ(folder.file_count(), 1U);
  ASSERT_TRUE(export_sheet(small_sheet_capture(), folder.path("pull.json"), true));
  EXPECT_TRUE(get_file(folder.path("pull.obj")).find("f 1/1 2/2 5/5\n") != std::string::npos);
}

constexpr const char* kTracked =
    "frame,point,x0_mm,y0_mm,ux_mm,uy_mm\n"
    "3,7,10,0,0,0\n3,8,20,5,0,0\n"
    "6,7,10,0,-1,0.5\n6,8,20,5,-0.25,\n";
constexpr const char* kPads = "frame,x,y\n0,9,9\n3,0,0\n4,9,9\n6,-1.5,0.25\n";
constexpr const char* kForce = "travel_mm,force_N\n0.5,-1\n0,0\n-1,2\n-2,6\n";

/// A film of two points between pads, its load cell on a clock of its own.
json film() {
  return json::parse(R"({
    "kind": "deforming_sheet", "title": "A film",
    "specimen": {"name": "A", "material": "skin"},
    "protocol": {"name": "pull", "history": "continues"},
    "provenance": {"source": "a test"},
    "positions": {"unit": "mm", "sigma": 0.02, "missing": "allowed", "columns": {
      "frame": "frame", "vertex": "point", "u": "x0_mm", "v": "y0_mm", "dx": "ux_mm", "dy": "uy_mm"}},
    "clips": [
      {"id": "moving", "role": "prescribed", "region": {"unit": "mm", "box": [[-4, -4], [4, 4]]},
       "pose": {"file": "pads.csv", "unit": "mm", "other_frames": "ignore",
                "columns": {"frame": "frame", "x": "x", "y": "y"}}},
      {"id": "fixed", "role": "prescribed", "region": {"unit": "mm", "polygon": [[32, -4], [32, 4]]},
       "pose": {"unit": "mm", "position": [36.5, 0, 0]}, "grip": "first_frame"}],
    "cords": [
      {"id": "pull", "clip": "moving", "direction": [-2, 0, 0], "tension": {
        "file": "force.csv", "unit": "N", "sigma": 0.01,
        "columns": {"over": "travel_mm", "tension": "force_N"},
        "over": {"clip": "moving", "coordinate": "x", "unit": "mm"}}}],
    "gravity_m_s2": [0, 0, 0]
  })");
}

struct Tables {
  std::string tracked = kTracked;
  std::string pads = kPads;
  std::string force = kForce;
};

Expected<Capture> import_film(const json& description, const Tables& tables = {}) {
  const TempFolder folder;
  put_file(folder.path("film.json"), description.dump());
  put_file(folder.path("tracked.csv"), tables.tracked);
  put_file(folder.path("pads.csv"), tables.pads);
  put_file(folder.path("force.csv"), tables.force);
  auto capture = import_sheet(folder.path("film.json"), folder.path("tracked.csv"));
  if (capture) return capture;
  std::string message = capture.error().message;
  EXPECT_EQ(capture.error().kind, ErrorKind::bad_input) << message;
  for (std::size_t at; (at = message.find(folder.folder() + "/")) != std::string::npos;)
    message.erase(at, folder.folder().size() + 1);
  return fail(capture.error().kind, message);
}

TEST(SheetImport, PointsWithAForceOverTheWayOfAClip) {
  const auto capture = import_film(film());
  ASSERT_TRUE(capture) << message_of(capture);
  const Sheet& sheet = *capture->sheet;
  EXPECT_EQ(capture->frame, (std::vector<int>{3, 6}));
  EXPECT_EQ(sheet.vertex_name, (std::vector<std::string>{"7", "8"}));
  EXPECT_EQ(sheet.coordinates, 2);
  EXPECT_DOUBLE_EQ(sheet.material_m[1][0], 0.02);
  EXPECT_DOUBLE_EQ(sheet.position_m[sheet.at(1, 0)], 0.009);
  EXPECT_DOUBLE_EQ(sheet.position_m[sheet.at(1, 0) + 1], 0.0005);
  EXPECT_TRUE(std::isnan(sheet.position_m[sheet.at(1, 1) + 1]));
  EXPECT_DOUBLE_EQ(sheet.sigma_m, 2e-5);
  EXPECT_EQ(sheet.clips[0].region_m.size(), 4U);
  EXPECT_DOUBLE_EQ(sheet.clips[0].pose[1].position_m[0], -0.0015);
  EXPECT_DOUBLE_EQ(sheet.clips[1].grip.position_m[0], -0.0365);
  EXPECT_EQ(sheet.cords[0].direction[1], (Vec3{-1.0, 0.0, 0.0}));
  EXPECT_DOUBLE_EQ(sheet.cords[0].tension_N[0], 0.0);
  EXPECT_DOUBLE_EQ(sheet.cords[0].tension_N[1], 4.0);  // half way from 2 to 6
  EXPECT_EQ(capture->branch, (std::vector<Branch>{Branch::load, Branch::load}));
  EXPECT_EQ(capture->provenance.imported_from, "tracked.csv");
  expect_round_trip(*capture);
}

TEST(SheetImport, ColumnsForEveryPointAndPlacesFromTheFirstFrame) {
  const TempFolder folder;
  put_file(folder.path("knit.csv"),
           "run,frame,time_s,force_N,l_x,l_y,r_x,r_y,clamp_x,clamp_y\n"
           "1,1,0,0,10,50,60,52,35,4\n1,5,0.1,2,12,50,58,52,35,2\n"
           "2,1,0,0.1,10,51,60,52,35,4\n2,9,0.3,2.5,12,50,58,52,35,1\n");
  json description = film();
  description["positions"] = json::parse(R"({"unit": "mm", "material": "first_frame",
    "columns": {"run": "run", "frame": "frame"}, "points": [
      {"name": "left", "columns": {"x": "l_x", "y": "l_y"}},
      {"name": "right", "columns": {"x": "r_x", "y": "r_y"}}]})");
  description["frames"] = json::parse(R"({"columns": {
    "run": {"is": "run"}, "frame": {"is": "frame"}, "time_s": {"is": "time", "unit": "s"}}})");
  description["protocol"]["repeats"] = true;
  description["clips"] = json::parse(R"([{"id": "top", "role": "prescribed", "grip": "first_frame",
    "region": {"unit": "mm", "box": [[0, 0], [100, 4]]}, "pose": {"unit": "mm",
      "columns": {"run": "run", "frame": "frame", "x": "clamp_x", "y": "clamp_y"}}}])");
  description["cords"] = json::parse(R"([{"id": "gauge", "clip": "top", "direction": [0, -1, 0],
    "tension": {"unit": "N", "columns": {"run": "run", "frame": "frame", "tension": "force_N"}}}])");
  put_file(folder.path("knit.json"), description.dump());
  const auto capture = import_sheet(folder.path("knit.json"), folder.path("knit.csv"));
  ASSERT_TRUE(capture) << message_of(capture);
  const Sheet& sheet = *capture->sheet;
  EXPECT_EQ(capture->runs.size(), 2U);
  EXPECT_EQ(capture->frame, (std::vector<int>{1, 5, 1, 9}));
  EXPECT_DOUBLE_EQ(capture->time_s[3], 0.3);
  EXPECT_DOUBLE_EQ(sheet.material_m[1][1], 0.052);
  EXPECT_DOUBLE_EQ(sheet.position_m[sheet.at(2, 0) + 1], 0.051);
  EXPECT_DOUBLE_EQ(sheet.cords[0].tension_N[3], 2.5);
  EXPECT_DOUBLE_EQ(sheet.clips[0].grip.position_m[1], -0.004);
  expect_round_trip(*capture);
}

TEST(SheetImport, AMeshFromAnotherProgram) {
  const TempFolder folder;
  put_file(folder.path("sheet.obj"),
           "v 0 0 5\nv 90 0 1\nv 100 80 0\nv 0 95 0\n"
           "vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
  put_file(folder.path("seen.csv"),
           "frame,vertex,x,y,z\n1,4,0,95,1\n1,1,0,0,5\n1,2,90,0,1\n1,3,100,80,0\n");
  json description = film();
  description["mesh"] = {{"file", "sheet.obj"},
                         {"unit", "mm"},
                         {"texture_unit", {{"value", 200}, {"unit", "mm"}}},
                         {"first_vertex", 1}};
  description["positions"] = json::parse(R"({"unit": "mm", "columns": {
    "frame": "frame", "vertex": "vertex", "x": "x", "y": "y", "z": "z"}})");
  description["clips"] = json::parse(R"([{"id": "corner", "role": "free", "vertices": ["1", "4"],
    "mass": {"value": 2, "unit": "g"}, "pose": {"unit": "mm", "position": [0, 0, 0]}}])");
  description["cords"] = json::array();
  put_file(folder.path("sheet.json"), description.dump());
  const auto capture = import_sheet(folder.path("sheet.json"), folder.path("seen.csv"));
  ASSERT_TRUE(capture) << message_of(capture);
  const Sheet& sheet = *capture->sheet;
  EXPECT_EQ(sheet.triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_DOUBLE_EQ(sheet.material_m[2][0], 0.1);
  EXPECT_DOUBLE_EQ(sheet.material_m[2][1], 0.2);
  EXPECT_DOUBLE_EQ(sheet.position_m[sheet.at(0, 3) + 1], 0.095);
  EXPECT_EQ(sheet.clips[0].vertices, (std::vector<int>{0, 3}));
  expect_round_trip(*capture);
  put_file(folder.path("sheet.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 9\n");
  EXPECT_EQ(message_of(import_sheet(folder.path("sheet.json"), folder.path("seen.csv"))),
            folder.path("sheet.obj") + ": OBJ, line 4: there is no node 9.");
}

TEST(SheetImport, SaysWhatItCannotUnderstand) {
  const auto complaint = [](const char* patch, const Tables& tables = {}) {
    json description = film();
    description.merge_patch(json::parse(patch));
    return message_of(import_film(description, tables));
  };
  EXPECT_EQ(complaint("{}"), "");
  EXPECT_EQ(complaint(R"({"gravity_m_s2": null})"),
            "film.json: gravity_m_s2 is missing: three numbers, all 0 where the weight does not "
            "count.");
  EXPECT_EQ(complaint(R"({"positions": {"unit": "N"}})"),
            "film.json: positions.unit: unit \"N\" cannot be turned into \"m\".");
  EXPECT_EQ(complaint(R"({"positions": {"columns": {"dx": "ux"}}})"),
            "tracked.csv: has no column \"ux\", which film.json names at positions.columns.dx; its "
            "columns are frame, point, x0_mm, y0_mm, ux_mm, uy_mm.");
  EXPECT_EQ(complaint(R"({"positions": {"columns": {"w": "ux"}}})"),
            "film.json: positions.columns.w is not one of run, frame, vertex, u, v, x, y, z, dx, "
            "dy, dz.");
  EXPECT_EQ(complaint(R"({"positions": {"missing": "error"}})"),
            "tracked.csv: line 5, column \"uy_mm\": is blank, and film.json does not declare "
            "missing values there.");
  EXPECT_EQ(complaint(R"({"surprise": 1})"), "film.json: surprise is not a known key.");
  EXPECT_EQ(complaint("{}", {.tracked = "frame,point,x0_mm,y0_mm,ux_mm,uy_mm\n3,7,10,0,0,x\n"}),
            "tracked.csv: line 2, column \"uy_mm\": \"x\" is not a number; \"skip_rows\": 1 in "
            "film.json leaves out a row of units.");
  EXPECT_EQ(complaint("{}", {.tracked = "frame,point,x0_mm,y0_mm,ux_mm,uy_mm\n3,7,1,0,0,0\n3,7,1,0,"
                                        "0,0\n"}),
            "tracked.csv: line 3, column \"point\": this vertex has been given for this frame.");
  EXPECT_EQ(complaint("{}", {.pads = "frame,x,y\n3,0,0\n"}),
            "pads.csv: has no row for run 1, frame 6, where a pose for clips[0].pose.columns is "
            "needed.");
  json strict = film();
  strict["clips"][0]["pose"].erase("other_frames");
  EXPECT_EQ(message_of(import_film(strict)),
            "pads.csv: line 2, column \"frame\": there is no frame 0; \"other_frames\": \"ignore\" "
            "passes over such rows.");
  EXPECT_EQ(complaint("{}", {.force = "travel_mm,force_N\n0,0\n-1,2\n-0.5,3\n"}),
            "force.csv: line 4, column \"travel_mm\": does not go on in one direction, so frames "
            "cannot be joined.");
  EXPECT_EQ(complaint("{}", {.force = "travel_mm,force_N\n0,0\n-1,2\n"}),
            "force.csv: has no tension where clip \"moving\" is in frame 6, and film.json does not "
            "declare missing values.");
}

TEST(SheetImport, IsShownInWords) {
  const std::string text = show_text(small_sheet_capture());
  EXPECT_NE(text.find("mesh        front: 9 vertices, 8 triangles, u 0 .. 100 mm, v 0 .. 100 mm\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("positions   3 coordinates, sigma per vertex, 1 not seen\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("cord        pull at moved: 0.1 .. 0.4 N, sigma 0.003 N, missing 1\n"),
            std::string::npos)
      << text;
  const auto shown = show_json(small_sheet_capture());
  EXPECT_EQ(shown["sheet"]["mesh"]["not_seen"], 1);
  EXPECT_EQ(shown["sheet"]["clips"][1]["role"], "free");
  EXPECT_EQ(shown["sheet"]["supports"][0]["edge_m"][1], 0.03);
}

}  // namespace
}  // namespace tenter::capture
