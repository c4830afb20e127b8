// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "common/capture/csv/csv_export.h"
#include "common/capture/csv/csv_import.h"
#include "common/capture/file/capture_file.h"
#include "common/capture/show.h"
#include "common/capture/strips/strip_photographs.h"
#include "common/capture/strips/strip_profiles.h"
#include "tests/common/capture/support.h"

namespace tenter::capture {
namespace {

using nlohmann::json;

json description_of_strips() {
  return json::parse(R"({
    "kind": "strip_profiles", "title": "Strips",
    "columns": {
      "strip": {"is": "run"},
      "x_mm": {"channel": "x", "quantity": "position", "unit": "mm", "point": "strip",
               "coordinate": "x", "sigma": 0.1},
      "y_mm": {"channel": "y", "quantity": "position", "unit": "mm", "point": "strip",
               "coordinate": "y", "sigma": 0.1},
      "radius_mm": {"channel": "radius", "quantity": "length", "unit": "mm"},
      "length_mm": {"channel": "length", "quantity": "length", "unit": "mm"}
    },
    "specimen": {"name": "1", "material": "felt", "area_density": {"value": 208, "unit": "g/m2"}},
    "protocol": {"name": "spirals", "history": "virgin_each_run"},
    "provenance": {"source": "a lab"}
  })");
}

/// Two quarter circles of 63 mm, 20 points each.
std::string two_strips(double second_radius_mm = 0.0, int points = 20) {
  std::ostringstream csv;
  csv << "strip,x_mm,y_mm,radius_mm,length_mm\n";
  for (int s = 1; s <= 2; ++s)
    for (int i = 0; i < points; ++i) {
      const double angle = M_PI / 2.0 * i / (points - 1);
      csv << s << ',' << 40.0 * (1.0 - std::cos(angle)) << ',' << -40.0 * std::sin(angle) << ','
          << (s == 1 ? 5.0 : second_radius_mm) << ',' << 20.0 * M_PI << '\n';
    }
  return csv.str();
}

TEST(StripProfiles, ComeFromAFileAndGoBackToIt) {
  const auto capture = test::import_text(two_strips(), description_of_strips().dump());
  ASSERT_TRUE(capture) << capture.error().message;
  const auto strips = strip_profiles(*capture);
  ASSERT_TRUE(strips) << strips.error().message;
  ASSERT_EQ(strips->size(), 2U);
  EXPECT_NEAR(strips->front().radius_m, 0.005, 1e-12);
  EXPECT_EQ(strips->back().radius_m, 0.0);
  EXPECT_EQ(strips->back().first_frame, 20U);
  ASSERT_EQ(strips->back().points_m.size(), 20U);
  EXPECT_NEAR(strips->back().points_m.back()[0], 0.04, 1e-12);
  EXPECT_NEAR(strips->back().points_m.back()[1], -0.04, 1e-12);
  EXPECT_NEAR(strips->front().length_m, 0.02 * M_PI, 1e-6);
  EXPECT_NEAR(strip_point_sigma(*capture), 1e-4, 1e-15);
  const test::TempFolder folder;
  ASSERT_TRUE(write_capture(*capture, folder.path("a.h5")));
  const auto again = read_capture_guarded(folder.path("a.h5"));
  ASSERT_TRUE(again) << again.error().message;
  const CsvExport files = export_csv(*again);
  const auto third = test::import_text(files.csv, files.description);
  ASSERT_TRUE(third) << third.error().message;
  EXPECT_EQ(test::bytes_of(*third), test::bytes_of(*capture));
  EXPECT_EQ(show_text(*capture).find("stretch x"), std::string::npos);
}

TEST(StripProfiles, SayWhatIsWrong) {
  const auto refusal = [](const std::string& csv, const json& patch) {
    json description = description_of_strips();
    description.merge_patch(patch);
    return test::message_of(test::import_text(csv, description.dump()));
  };
  const auto says = [](const std::string& message, const char* words) {
    return message.find(words) != std::string::npos ? "" : "\"" + message + "\"";
  };
  EXPECT_EQ(says(refusal(two_strips(-2.0), json::object()), "strip of run 2: the radius"), "");
  EXPECT_EQ(says(refusal(two_strips(0.0, 9), json::object()), "strip of run 1 has 9 points"), "");
  EXPECT_EQ(says(refusal(two_strips(), {{"specimen", {{"area_density", nullptr}}}}),
                 "specimen.area_density"),
            "");
  json no_length;
  no_length["columns"]["length_mm"] = "ignore";
  EXPECT_EQ(says(refusal(two_strips(), no_length), "specimen.length"), "");
  json inches;
  inches["columns"]["length_mm"]["unit"] = "inch";
  EXPECT_EQ(says(refusal(two_strips(), inches), "a wrong unit, scale or strip?"), "");
  json one_run;
  one_run["columns"]["strip"] = "ignore";
  EXPECT_EQ(says(refusal(two_strips(), one_run), "its radius changes"), "");
  json other_point;
  other_point["columns"]["y_mm"]["point"] = "else";
  EXPECT_EQ(says(refusal(two_strips(), other_point), "of one point name"), "");
}

/// A quarter circle of 40 mm around the middle of the picture's left edge, as a band of 8 pixels.
void draw(const std::string& path) {
  constexpr int kSide = 480;
  std::vector<std::uint8_t> level(kSide * kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double away = std::abs(std::hypot(x - 440.0, y - 40.0) - 400.0);
      const bool is_there = y >= 40 && x <= 440;
      level[static_cast<std::size_t>(y * kSide + x)] =
          is_there ? static_cast<std::uint8_t>(230.0 -
                                               190.0 * std::fmin(1.0, std::fmax(0.0, 4.5 - away)))
                   : 230;
    }
  png_image picture;
  std::memset(&picture, 0, sizeof picture);
  picture.version = PNG_IMAGE_VERSION;
  picture.width = picture.height = kSide;
  picture.format = PNG_FORMAT_GRAY;
  ASSERT_NE(png_image_write_to_file(&picture, path.c_str(), 0, level.data(), 0, nullptr), 0);
}

TEST(StripPhotographs, BecomeACapture) {
  const test::TempFolder folder;
  draw(folder.path("a.png"));
  json description = description_of_strips();
  description.erase("columns");
  description["pixel"] = {{"value", 0.1}, {"unit", "mm"}};
  description["photographs"] = json::array({{{"file", "a.png"},
                                             {"clamp", {40, 40}},
                                             {"radius", {{"value", 5}, {"unit", "mm"}}},
                                             {"sense", "negative"}}});
  test::put_file(folder.path("strips.json"), description.dump());
  ASSERT_TRUE(describes_strip_photographs(description.dump()));
  EXPECT_FALSE(describes_strip_photographs(description_of_strips().dump()));
  const auto capture = import_strip_photographs(folder.path("strips.json"));
  ASSERT_TRUE(capture) << capture.error().message;
  const auto strips = strip_profiles(*capture);
  ASSERT_TRUE(strips);
  ASSERT_EQ(strips->size(), 1U);
  const StripProfile& strip = strips->front();
  EXPECT_EQ(strip.sense, -1);
  EXPECT_NEAR(strip.length_m, 0.02 * M_PI, 1e-4);
  double largest_m = 0.0;
  for (std::size_t i = 1; i + 1 < strip.points_m.size(); ++i) {
    const auto& p = strip.points_m[i];
    largest_m = std::fmax(largest_m, std::abs(std::hypot(p[0] - 0.04, p[1]) - 0.04));
  }
  EXPECT_LT(largest_m, 1e-5);
  // the last column that is dark ends half a pixel beyond its middle
  EXPECT_LT(std::hypot(strip.points_m.back()[0] - 0.04005, strip.points_m.back()[1] + 0.04), 3e-5);
  EXPECT_EQ(capture->provenance.imported_from, "a.png");
  EXPECT_EQ(capture->provenance.imported_sha256.size(), 64U);

  const auto refusal = [&](const char* patch) {
    json changed = description;
    changed.merge_patch(json::parse(patch));
    test::put_file(folder.path("strips.json"), changed.dump());
    return test::message_of(import_strip_photographs(folder.path("strips.json")));
  };
  EXPECT_NE(refusal(R"({"pixel": null})").find("strips.json: photographs[0].pixel is missing"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"photographs": [{"file": "a.png", "clamp": [7]}]})").find("[0].clamp must"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"photographs": [{"file": "a.png", "clamp": [300, 300]}]})")
                .find("a.png: nothing darker"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"photographs": [{"file": "b.png", "clamp": [40, 40]}]})").find("b.png"),
            std::string::npos);
  test::put_file(folder.path("a.png"), "no picture");
  EXPECT_NE(refusal("{}").find("is no PNG"), std::string::npos);
}

}  // namespace
}  // namespace tenter::capture
