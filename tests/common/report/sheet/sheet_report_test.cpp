// SPDX-License-Identifier: Apache-2.0
#include "common/report/sheet/sheet_report.h"

#include <gtest/gtest.h>

#include "common/report/html_report.h"
#include "common/report/sheet/document.h"
#include "common/report/sheet/mesh_svg.h"
#include "tests/common/report/page_checks.h"
#include "tests/common/report/sheet/fixture_sheet.h"

namespace tenter::report {
namespace {

using fixture::count;
using fixture::page_of;
using fixture::poison;

TEST(SheetReport, ShowsEveryPartOfTheResult) {
  const std::string page = page_of(fixture::sheet_fit());
  for (const char* anchor :
       {"captures", "curves", "loops", "sheets", "stages", "parameters", "starts", "convexity",
        "samples", "limit", "grid-error", "correlations", "model", "checklist"})
    EXPECT_EQ(count(page, "<section id=\"" + std::string(anchor) + "\""), 1U) << anchor;
  EXPECT_EQ(count(page, "<svg class=\"plot\""), 5U);
  EXPECT_EQ(count(page, "<svg class=\"mesh\""), 3U);
  EXPECT_EQ(count(page, "series ribbon"), 1U);
  EXPECT_EQ(count(page, "class=\"unseen\""), 4U);  // below and above, of two curves
  for (const char* words :
       {"2 frames without an estimate: their forces were not fitted",
        "at most 30\u202fmN; 4\u202f\u03c3",
        "the estimate was still changing by 0.4",
        "held: the captures do not tell it",
        "forces by 3.3\u202fmN (1.1\u202f\u03c3) and positions by 0.081\u202fmm",
        "1 held out",
        "41\u202fmN \u2192 3.3\u202fmN",
        ">HELD OUT</span>",
        "frame 17: no stable equilibrium",
        "31 of 656 vertices",
        ">not done</span>",
        "at a bound: <code>shear.k</code>",
        "-0.94",
        "starting model</button>",
        "fitted model</button>",
        "shaded: never seen",
        "frame 16: largest displacement",
        ">one sided</span><div class=\"soft\">above 0.125<",
        "<th>Profile likelihood</th>",
        "2 of 4 starts ended within 1",
        "1 start ended without",
        "least so: <code>weft</code>, eigenvalue -3.5",
        "75\u202fmm, 25\u202fmm",
        "without 36 rows",
        "1.25 \u00b1 0.03"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  // the first screen is the table of captures, what was held out at its end
  EXPECT_LT(page.find("id=\"captures\""), page.find("id=\"curves\""));
  EXPECT_LT(page.find("FIXTURE wool, bend_u"), page.find("FIXTURE wool, evaluation"));
}

TEST(SheetReport, SyntheticCapturesAreLabelledWhereverTheyAppear) {
  // the note at the top, the table of captures, the loop
  EXPECT_EQ(count(page_of(fixture::sheet_fit()), ">SYNTHETIC</span>"), 3U);
}

TEST(SheetReport, HostileTextStaysTextAndNothingIsLoaded) {
  for (const std::string& attack :
       {std::string("<script>alert(1)</script>"), std::string("\"><img src=x onerror=alert(1)>")}) {
    Json result = fixture::sheet_fit();
    poison(result, attack);
    const std::string page = page_of(result);
    EXPECT_EQ(count(page, "<script"), 1U);
    EXPECT_EQ(page.find("<img"), std::string::npos);
    EXPECT_EQ(page.find("http:"), std::string::npos);
  }
}

TEST(SheetReport, SurvivesWrongTypesAndMissingKeys) {
  const Json good = fixture::sheet_fit();
  for (const auto& item : good.items()) {
    if (item.key() == "schema" || item.key() == "version") continue;
    for (const Json& odd : {Json(nullptr), Json("text"), Json::array({1, "a", nullptr}),
                            Json{{"a", 1}}, Json::array({Json{{"triangles", {{0, 1, 99}}}}})}) {
      Json result = good;
      result[item.key()] = odd;
      EXPECT_TRUE(render_html(result.dump())) << item.key() << " " << odd;
      EXPECT_TRUE(render_text(result.dump())) << item.key() << " " << odd;
    }
  }
}

TEST(SheetReport, TextSaysErrorsStagesAndWarnings) {
  const std::string text = render_text(fixture::sheet_fit().dump()).value();
  for (const char* words :
       {"The fit misses forces by 3.3\u202fmN", "Fit of 4 captures of a sheet with cloth_stvk",
        "41\u202fmN -> 6.2\u202fmN", "[HELD OUT]", "1 frames dropped", "stretch u", "not done",
        "WARNING", "Frames dropped", "one sided", "above 0.125", "2 of 4 in the best basin",
        "1 of 1 tried were kept; held-out cost 800 -> 640", "yes; cost 4100 -> 4300",
        "the limit \"lock\" is reached",
        "taken off: up to 12\u202fmN and 0\u202fnm of a capture (rms), still changing"})
    EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
}

TEST(SheetReport, QuantitiesReadInTheUnitOfTheirSize) {
  EXPECT_EQ(sheet::quantity(0.0033, "N"), "3.3\u202fmN");
  EXPECT_EQ(sheet::quantity(1.25, "N"), "1.25\u202fN");
  EXPECT_EQ(sheet::quantity(2e-5, "N"), "20\u202f\u00b5N");
  EXPECT_EQ(sheet::quantity(8.13e-5, "m"), "0.0813\u202fmm");
  EXPECT_EQ(sheet::quantity(0.25, "m"), "250\u202fmm");
  EXPECT_EQ(sheet::quantity(0.0, "m"), "0\u202fnm");
  EXPECT_EQ(sheet::quantity({}, "m"), "\u2013");
}

TEST(MeshPicture, IsSeenAlongItsNarrowestAxisWithArrowsFiveTimesTheResidual) {
  // a square in the plane y = 0, 0.1 m wide: 528 units of the picture are 0.1 m
  Json mesh = {{"position_m", {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0, 0.05}, {0, 0, 0.05}}},
               {"triangles", {{0, 1, 2}, {0, 2, 3}}},
               {"residual_m", {0.0, 0.0, 3e-3, nullptr}},
               {"arrows", {{{"at_m", {0, 0, 0}}, {"residual_m", {1e-3, 0.0, 1e-3}}}}}};
  const std::string svg = sheet::mesh_svg(mesh);
  EXPECT_NE(svg.find("x to the right and z up"), std::string::npos);
  EXPECT_NE(svg.find("M16.0 280.0L544.0 280.0L544.0 16.0Z"), std::string::npos) << svg;
  // 1 mm x 5 x 5280 units a metre
  EXPECT_NE(svg.find("M16.0 280.0l26.4 -26.4"), std::string::npos) << svg;
  EXPECT_EQ(count(svg, "class=\"face s"), 2U);
  mesh["residual_m"] = Json::array();
  EXPECT_EQ(count(sheet::mesh_svg(mesh), "face unmeasured"), 2U);
  mesh["triangles"] = Json::array({{0, 1, 7}, {0, 1}});
  EXPECT_EQ(sheet::mesh_svg(mesh), "");
}

TEST(MeshPicture, NearTrianglesAreDrawnLast) {
  // two triangles over each other, seen from above; the second is higher
  const Json mesh = {
      {"position_m", {{0, 0, 0.01}, {1, 0, 0.01}, {0, 1, 0.01}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},
      {"triangles", {{0, 1, 2}, {3, 4, 5}}},
      {"residual_m", {1.0, 1.0, 1.0, 0.0, 0.0, 0.0}}};
  const std::string svg = sheet::mesh_svg(mesh);
  EXPECT_LT(svg.find("face s0"), svg.find("face s9"));
}

}  // namespace
}  // namespace tenter::report
