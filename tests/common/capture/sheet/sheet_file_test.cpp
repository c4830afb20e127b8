// SPDX-License-Identifier: Apache-2.0
// A deforming sheet on disk: what was written comes back to the bit, and what makes no sense is
// said.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <iostream>

#include "common/capture/file/capture_file.h"
#include "common/capture/validate.h"
#include "common/h5/reader.h"
#include "tests/common/capture/sheet/support.h"
#include "tests/common/capture/support.h"

namespace tenter::capture {
namespace {

using test::bytes_of;
using test::message_of;
using test::rippled_sheet_capture;
using test::small_capture;
using test::small_sheet_capture;
using test::TempFolder;

TEST(SheetFile, ReadsWhatItWrote) {
  const TempFolder folder;
  const Capture written = small_sheet_capture();
  ASSERT_TRUE(write_capture(written, folder.path("c.h5")));
  std::vector<std::string> ignored;
  const auto read = read_capture_guarded(folder.path("c.h5"), &ignored);
  ASSERT_TRUE(read) << message_of(read);
  EXPECT_TRUE(ignored.empty());
  ASSERT_TRUE(read->sheet);
  const Sheet& a = *read->sheet;
  const Sheet& b = *written.sheet;
  EXPECT_EQ(a.name, "front");
  EXPECT_EQ(a.material_m, b.material_m);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.outline_m, b.outline_m);
  EXPECT_EQ(a.sigma_per_vertex_m, b.sigma_per_vertex_m);
  EXPECT_TRUE(std::isnan(a.position_m[a.at(2, 4)]));
  EXPECT_EQ(a.position_m[a.at(3, 8)], b.position_m[b.at(3, 8)]);
  ASSERT_EQ(a.clips.size(), 2U);
  EXPECT_EQ(a.clips[0].id, "fixed");  // the order is kept, not that of the names
  EXPECT_EQ(a.clips[0].region_m, b.clips[0].region_m);
  EXPECT_TRUE(a.clips[1].is_free);
  EXPECT_EQ(a.clips[1].vertices, b.clips[1].vertices);
  EXPECT_EQ(a.clips[1].pose[3].rotation, b.clips[1].pose[3].rotation);
  EXPECT_EQ(a.clips[1].grip.position_m, b.clips[1].grip.position_m);
  ASSERT_EQ(a.cords.size(), 2U);
  EXPECT_EQ(a.cords[0].id, "pull");
  EXPECT_EQ(a.cords[0].direction, b.cords[0].direction);
  EXPECT_TRUE(std::isnan(a.cords[0].tension_N[2]));
  ASSERT_EQ(a.supports.size(), 1U);
  EXPECT_EQ(a.supports[0].edge_m, b.supports[0].edge_m);
  EXPECT_EQ(a.supports[0].along, 'v');
  EXPECT_FALSE(a.supports[0].bears_above);
  EXPECT_EQ(a.gravity_m_s2, b.gravity_m_s2);
  ASSERT_TRUE(a.slack);
  EXPECT_EQ(a.slack->clips, b.slack->clips);
  EXPECT_EQ(a.slack->closer_than_m, 0.300005);
  EXPECT_TRUE(a.is_slack(1));
  EXPECT_FALSE(a.is_slack(2));
  EXPECT_EQ(bytes_of(*read), bytes_of(written));
  Capture other = written;
  other.sheet->position_m[5] += 1e-15;
  EXPECT_NE(bytes_of(other), bytes_of(written));
}

TEST(SheetFile, PointsWithoutAMeshInThePlane) {
  Capture points = small_sheet_capture();
  Sheet& sheet = *points.sheet;
  sheet.triangles.clear();
  sheet.coordinates = 2;
  sheet.position_m.assign(4 * 9 * 2, 0.25);
  for (std::size_t k = 0; k < 9; ++k) sheet.vertex_name.push_back("p" + std::to_string(k));
  sheet.clips[1].vertices.clear();
  sheet.clips[1].region_m = {{0.1, 0.0}, {0.1, 0.1}};
  const TempFolder folder;
  ASSERT_TRUE(write_capture(points, folder.path("c.h5")));
  const auto read = read_capture(folder.path("c.h5"));
  ASSERT_TRUE(read) << message_of(read);
  EXPECT_EQ(read->sheet->coordinates, 2);
  EXPECT_EQ(read->sheet->vertex_name, sheet.vertex_name);
  EXPECT_EQ(bytes_of(*read), bytes_of(points));
}

TEST(SheetFile, OtherKindsStayVersionOne) {
  const TempFolder folder;
  ASSERT_TRUE(write_capture(small_capture(), folder.path("one.h5")));
  ASSERT_TRUE(write_capture(small_sheet_capture(), folder.path("two.h5")));
  const auto one = h5::H5Reader::open(folder.path("one.h5"));
  const auto two = h5::H5Reader::open(folder.path("two.h5"));
  EXPECT_EQ(one->integer_attribute("/", "version").value(), 1);
  EXPECT_EQ(two->integer_attribute("/", "version").value(), 2);
  EXPECT_FALSE(one->has("/entry/meshes").value());
  // what a viewer shows first: the tension of the first cord
  EXPECT_EQ(two->text_attribute("/entry", "default").value(), "cords");
  EXPECT_EQ(two->text_attribute("/entry/cords", "default").value(), "pull");
  EXPECT_EQ(two->text_attribute("/entry/cords/pull", "signal").value(), "tension");
}

TEST(SheetFile, TenThousandVerticesOverFortyFrames) {
  const TempFolder folder;
  const Capture capture = rippled_sheet_capture(100, 40);
  auto seconds = [start = std::chrono::steady_clock::now()]() mutable {
    const auto before = std::exchange(start, std::chrono::steady_clock::now());
    return std::chrono::duration<double>(start - before).count();
  };
  ASSERT_TRUE(write_capture(capture, folder.path("c.h5")));
  const double writing = seconds();
  const auto read = read_capture(folder.path("c.h5"));
  const double reading = seconds();
  ASSERT_TRUE(read) << message_of(read);
  EXPECT_EQ(read->sheet->vertex_count(), 10000U);
  EXPECT_EQ(read->sheet->position_m, capture.sheet->position_m);
  std::cout << "10,000 vertices x 40 frames: written in " << writing << " s, read in " << reading
            << " s\n";
}

TEST(SheetFile, SaysWhatMakesNoSense) {
  const auto complaint = [](const std::function<void(Capture&)>& spoil) {
    Capture capture = small_sheet_capture();
    spoil(capture);
    return message_of(validate(capture));
  };
  EXPECT_EQ(complaint([](Capture&) {}), "");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet.reset(); }),
            "a capture of kind \"deforming_sheet\" needs a sheet");
  EXPECT_EQ(complaint([](Capture& c) { c.kind = "tracked_points"; }),
            "a capture of kind \"tracked_points\" has no sheet");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->triangles[3][1] = 9; }),
            "triangle 3 names vertex 9 of 9");
  EXPECT_EQ(
      complaint([](Capture& c) { std::swap(c.sheet->triangles[3][1], c.sheet->triangles[3][2]); }),
      "triangle 3 has no area, or runs clockwise in the material");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->position_m.pop_back(); }),
            "there are 107 coordinates for 4 frames of 27 coordinates");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->may_be_missing = false; }),
            "vertex 4 has no position at run 5, frame 1 and missing positions are not declared");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->clips[0].vertices = {1}; }),
            "clip \"fixed\" must clamp either a region of the material or vertices");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->clips[1].vertices[2] = -1; }),
            "clip \"moved\" clamps vertex -1 of 9");
  EXPECT_EQ(complaint([](Capture& c) {
              c.sheet->clips[1].pose[2].rotation = {1, 1, 0, 0};
            }),
            "clip \"moved\" has a rotation that is no unit quaternion at run 5, frame 1");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->clips[1].id = "fixed"; }),
            "clip \"fixed\" appears twice");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->cords[0].clip = "third"; }),
            "cord \"pull\" names clip \"third\", which is not there");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->cords[0].may_be_missing = false; }),
            "cord \"pull\" has no tension at run 5, frame 1 and does not declare missing values");
  EXPECT_EQ(complaint([](Capture& c) {
              c.sheet->cords[1].direction[1] = {0, 0, 2};
            }),
            "cord \"hang\" has a direction that is not of length one at run 2, frame 2");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->slack->clips[1] = "fixed"; }),
            "slack frames are told by clip \"fixed\" and itself");
  EXPECT_EQ(complaint([](Capture& c) { c.sheet->supports[0].edge_m.pop_back(); }),
            "support \"table\" has 3 edges for 4 frames");
}

}  // namespace
}  // namespace tenter::capture
