// SPDX-License-Identifier: Apache-2.0
#include "common/report/experiment/figure.h"
#include "common/report/experiment/found.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "common/report/experiment/mesh_painter.h"
#include "tests/common/report/experiment/fixture_simulation.h"

namespace tenter::report {
namespace {

struct Facet {
  std::string colour;
  double x[3], y[3];
};

/// The triangles of all paths, in the order in which they are painted.
std::vector<Facet> facets_of(const std::string& svg) {
  static const std::regex path("<path color=\"(#[0-9a-f]{6})\" d=\"([^\"]*)\"/>");
  static const std::regex triangle(
      "M([-0-9.]+) ([-0-9.]+)L([-0-9.]+) ([-0-9.]+) ([-0-9.]+) ([-0-9.]+)Z");
  std::vector<Facet> facets;
  for (std::sregex_iterator p(svg.begin(), svg.end(), path), end; p != end; ++p) {
    const std::string d = (*p)[2];
    for (std::sregex_iterator t(d.begin(), d.end(), triangle); t != end; ++t) {
      Facet facet{(*p)[1], {}, {}};
      for (std::size_t c = 0; c < 3; ++c) {
        facet.x[c] = std::stod((*t)[1 + 2 * c]);
        facet.y[c] = std::stod((*t)[2 + 2 * c]);
      }
      facets.push_back(facet);
    }
  }
  return facets;
}

constexpr View kFromFront{{0.0, -1.0, 0.0}, {0.0, 0.0, 1.0}};

TEST(MeshPainter, PaintsFromBackToFrontInsideTheCanvas) {
  // three triangles at y = 0, 1, 2, seen from -y: the first is in front
  std::vector<Point3> points;
  for (const double y : {0.0, 2.0, 1.0})
    for (const Point3& p : {Point3{0.0, y, 0.0}, Point3{2.0 + y, y, 0.0}, Point3{0.0, y, 1.0}})
      points.push_back(p);
  const std::vector<Corners> triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  const Canvas canvas{200.0, 100.0, 10.0, std::nullopt};
  const auto facets = facets_of(painted_mesh(points, triangles, kFromFront, canvas));
  ASSERT_EQ(facets.size(), 3U);
  const double scale = 180.0 / 4.0;  // the widest is 4 m
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(facets[i].x[1] - facets[i].x[0], scale * (4.0 - static_cast<double>(i)), 0.11);
    EXPECT_NEAR(facets[i].y[0] - facets[i].y[2], scale, 0.11);  // z is up
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_GE(facets[i].x[c], 9.9);
      EXPECT_LE(facets[i].x[c], 190.1);
      EXPECT_GE(facets[i].y[c], 9.9);
      EXPECT_LE(facets[i].y[c], 90.1);
    }
  }
}

TEST(MeshPainter, ShadesByAngleAndTellsTheSides) {
  const std::vector<Point3> points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 0.2}};
  const auto fill = [&](const Corners& triangle, const View& view) {
    const auto facets = facets_of(painted_mesh(points, {triangle}, view, {}));
    EXPECT_EQ(facets.size(), 1U);
    return facets.empty() ? std::string() : facets[0].colour;
  };
  const std::string facing = fill({0, 1, 2}, kFromFront);
  EXPECT_NE(facing, fill({0, 2, 1}, kFromFront));  // the other side
  EXPECT_NE(facing, fill({0, 1, 3}, {{0.9, -1.0, 1.0}, {0.0, 0.0, 1.0}}));
  EXPECT_EQ(facing, fill({0, 1, 4}, kFromFront));  // coplanar
}

TEST(MeshPainter, LeavesOutWhatIsNotThere) {
  const std::vector<Point3> points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {NAN, 0, 0}};
  EXPECT_EQ(
      facets_of(painted_mesh(points, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {-1, 1, 2}}, kFromFront, {}))
          .size(),
      1U);
  EXPECT_EQ(painted_mesh({}, {{0, 1, 2}}, kFromFront, {}), "");
  EXPECT_EQ(painted_mesh(points, {}, kFromFront, {}), "");
  EXPECT_EQ(painted_mesh({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}, kFromFront, {}), "");
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(ExperimentFigure, ShowsPicturesNumbersAndLinesOfEveryRun) {
  const auto svg = experiment_svg(fixture::simulation().dump());
  ASSERT_TRUE(svg) << svg.error().message;
  EXPECT_EQ(*svg, *experiment_svg(fixture::simulation().dump()));
  const auto facets = facets_of(*svg);
  ASSERT_EQ(facets.size(), 2U);
  // to one scale: the second is half as large
  EXPECT_NEAR(facets[0].x[1] - facets[0].x[0], 2.0 * (facets[1].x[1] - facets[1].x[0]), 0.2);
  for (const char* words : {">123.4<", ">5<", ">2<", "work (\u00b5J)", "rms curvature (1/m)",
                            "a &amp; b with felt", "with &lt;friction&gt;", "along (mm)"})
    EXPECT_NE(svg->find(words), std::string::npos) << words;
  EXPECT_EQ(svg->find("<friction>"), std::string::npos);
  EXPECT_EQ(count(*svg, "class=\"series r0\""), 1U);
  EXPECT_EQ(count(*svg, "class=\"series r1\""), 1U);
  EXPECT_EQ(count(*svg, "<svg"), count(*svg, "</svg>"));
  EXPECT_EQ(count(*svg, "<text"), count(*svg, "</text>"));
  EXPECT_EQ(svg->find("nan"), std::string::npos);
  const auto text = experiment_text(fixture::simulation().dump());
  ASSERT_TRUE(text);
  EXPECT_NE(text->find("without\n  rms curvature (1/m): 5\n"), std::string::npos) << *text;
}

TEST(ExperimentFigure, LinesOfOnePlotShareTheirUnits) {
  nlohmann::ordered_json motion = fixture::simulation();
  for (std::size_t r = 0; r < 2; ++r) {
    nlohmann::ordered_json& y = motion["experiment"]["runs"][r]["curves"][0]["y"];
    y["unit"] = "J";
    y["values"] = {0.0, r == 0 ? 2.5e-4 : 9e-5, 0.0};
  }
  const auto found = found_of(motion.dump());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->runs[0].lines[0].y_label, "curvature (mJ)");
  EXPECT_EQ(found->runs[1].lines[0].y_label, "curvature (mJ)");
  EXPECT_NEAR(found->runs[0].lines[0].y[1], 0.25, 1e-12);
  EXPECT_NEAR(found->runs[1].lines[0].y[1], 0.09, 1e-12);
}

TEST(ExperimentFigure, TakesOddDocumentsAsNothing) {
  EXPECT_FALSE(experiment_svg("{}"));
  EXPECT_FALSE(experiment_svg("no json"));
  nlohmann::ordered_json plain = fixture::simulation();
  plain.erase("experiment");
  EXPECT_FALSE(experiment_svg(plain.dump()));
  nlohmann::ordered_json odd = fixture::simulation();
  odd["experiment"]["runs"][0]["triangles"] = {{0, 1}, "x", {0, 1, 1e12}};
  odd["experiment"]["runs"][0]["curves"] = 3;
  odd["experiment"]["runs"][1]["pictures"][0]["position_m"] = nlohmann::ordered_json::array();
  odd["experiment"]["runs"][1]["reason"] = "a step failed";
  const auto svg = experiment_svg(odd.dump());
  ASSERT_TRUE(svg);
  EXPECT_TRUE(facets_of(*svg).empty());
  EXPECT_NE(svg->find("the run ended before"), std::string::npos);
  EXPECT_NE(svg->find("ended early: a step failed"), std::string::npos);
}

}  // namespace
}  // namespace tenter::report
