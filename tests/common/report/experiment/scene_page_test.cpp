// SPDX-License-Identifier: Apache-2.0
#include "common/report/experiment/scene_page.h"

#include <gtest/gtest.h>

#include "common/report/text_report.h"
#include "tests/common/report/experiment/fixture_simulation.h"
#include "tests/common/report/page_checks.h"

namespace tenter::report {
namespace {

using fixture::count;
using fixture::page_of;
using fixture::poison;

TEST(ScenePage, ShowsFigureNumbersForcesAndParameters) {
  const std::string page = page_of(fixture::simulation());
  EXPECT_EQ(page, page_of(fixture::simulation()));
  for (const char* words :
       {"<h1>a &amp; b with felt</h1>", "rolled up &lt;tightly&gt; and", "2 of 2",
        "4 steps, 14 iterations", "1152 triangles", "<th class=\"n\">rms curvature (1/m)</th>",
        "<td>with &lt;friction&gt;</td><td class=\"n\">123.4</td><td class=\"n\">2</td>",
        "<td>without</td><td class=\"n\">5</td>", "<td class=\"n\">4.75</td>",
        "<td class=\"n\">0.0125</td><td>J</td>",
        "<code>bend_v.k1</code></td><td class=\"n\">1.453e-05</td><td>N m</td>",
        "<code>friction_v.tau</code></td><td class=\"n\">29.9</td><td>1/m</td>"})
    EXPECT_EQ(count(page, words), 1U) << words;
  EXPECT_EQ(count(page, "<section id="), 5U);
  EXPECT_EQ(count(page, "<a href=\"#"), 5U);
  EXPECT_EQ(count(page, "ENDED EARLY"), 0U);
  EXPECT_EQ(count(page, "src="), 0U);
}

TEST(ScenePage, SaysWhereAWalkEnded) {
  Json result = fixture::simulation();
  result["completed"] = false;
  result["reason"] = "no equilibrium at frame 1";
  result["experiment"]["runs"][1]["reason"] = "a step failed";
  const std::string page = page_of(result);
  EXPECT_EQ(count(page, "ENDED EARLY</span> no equilibrium at frame 1"), 1U);
  EXPECT_EQ(count(page, ">ended early: a step failed<"), 2U);  // figure and table
}

TEST(ScenePage, WithoutAnExperimentThereIsNoFigure) {
  Json result = fixture::simulation();
  result.erase("experiment");
  const std::string page = page_of(result);
  EXPECT_EQ(count(page, "<section id="), 3U);
  EXPECT_EQ(count(page, "<section id=\"figure\""), 0U);
}

TEST(ScenePage, TakesOddDocumentsAndHostileText) {
  const Json good = fixture::simulation();
  for (const auto& item : good.items()) {
    if (item.key() == "schema" || item.key() == "version") continue;
    for (const Json& odd :
         {Json(nullptr), Json(3), Json("text"), Json::array({1, "a", nullptr}), Json{{"a", 1}}}) {
      Json result = good;
      result[item.key()] = odd;
      EXPECT_TRUE(render_html(result.dump())) << item.key() << " " << odd;
    }
  }
  Json hostile = good;
  poison(hostile, "</script><img src=x>");
  const std::string page = page_of(hostile);
  EXPECT_EQ(count(page, "<img"), 0U);
  EXPECT_GT(count(page, "&lt;img"), 5U);
  EXPECT_EQ(count(page, "</script>"), 1U);
  // as text there is none: that is said
  const auto words = render_text(good.dump(), {});
  ASSERT_FALSE(words);
  EXPECT_NE(words.error().message.find("is a simulated scene"), std::string::npos);
}

}  // namespace
}  // namespace tenter::report
