// SPDX-License-Identifier: Apache-2.0
#include "common/report/html_report.h"

#include <gtest/gtest.h>

#include <regex>

#include "tests/common/report/fixture_result.h"
#include "tests/common/report/page_checks.h"

namespace tenter::report {
namespace {

using fixture::count;
using fixture::page_of;
using fixture::poison;

TEST(HtmlReport, ShowsEveryPartOfTheResult) {
  const std::string page = page_of(fixture::result());
  for (const char* anchor : {"verdicts", "captures", "loops", "transverse", "residuals", "model",
                             "parameters", "path", "screen", "checklist"})
    EXPECT_EQ(count(page, "<section id=\"" + std::string(anchor) + "\""), 1u) << anchor;
  EXPECT_EQ(count(page, "<svg class=\"plot\""), 12u);
  EXPECT_EQ(count(page, "<figure>"), 12u);
  for (const char* words : {"NAMED", "AMBIGUOUS", "SENSOR", "UNEXPLAINED", "internal_friction",
                            "Could also be viscosity", "hold for 60 s", "friction_45.tau",
                            "not excited: no capture returns", "licence not stated"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  EXPECT_LT(page.find("id=\"verdicts\""), page.find("id=\"captures\""));
}

TEST(HtmlReport, SyntheticCapturesAreLabelledWhereverTheyAppear) {
  const std::string page = page_of(fixture::result());
  // the note at the top, the table of captures, and its four figures
  EXPECT_EQ(count(page, ">SYNTHETIC</span>"), 6u);
}

TEST(HtmlReport, LoopsKeepEveryBlockAndBothBranches) {
  const std::string page = page_of(fixture::result());
  const std::size_t loops = page.find("id=\"loops\"");
  const std::string section = page.substr(loops, page.find("</section>", loops) - loops);
  EXPECT_EQ(count(section, "<g class=\"series measured load\">"), 8u);
  EXPECT_EQ(count(section, "<g class=\"series measured unload\">"), 8u);
  EXPECT_NE(section.find("run 5, unloading"), std::string::npos);
  EXPECT_NE(section.find("series outlier"), std::string::npos);
}

TEST(HtmlReport, LoadsNothingFromAnywhere) {
  const std::string page = page_of(fixture::result());
  for (const char* what : {"http://", "https://", "src=", "url(", "@import", "<link", "<iframe"})
    EXPECT_EQ(page.find(what), std::string::npos) << what;
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(HtmlReport, SameDocumentSameBytes) {
  EXPECT_EQ(page_of(fixture::result()), page_of(fixture::result()));
}

TEST(HtmlReport, HostileTextStaysText) {
  for (const std::string& attack :
       {std::string("<script>alert(1)</script>"), std::string("\"><img src=x onerror=alert(1)>"),
        std::string("</title></style></svg><svg onload=alert(1)>"), std::string("' onmouseover='x"),
        std::string("javascript:alert(1)"), std::string("\x1b[31m\x01\x7f&amp;")}) {
    Json result = fixture::result();
    poison(result, attack);
    const std::string page = page_of(result);
    EXPECT_EQ(count(page, "<script"), 1u);
    EXPECT_EQ(page.find("<img"), std::string::npos);
    EXPECT_EQ(page.find("<svg onload"), std::string::npos);
    EXPECT_EQ(page.find('\x1b'), std::string::npos);
    EXPECT_FALSE(std::regex_search(page, std::regex("<[a-z][^>\"]* on[a-z]+=")));
    EXPECT_EQ(page.find("href=\"javascript"), std::string::npos);
  }
}

TEST(HtmlReport, ShowsAFitWithoutVerdicts) {
  const Json fit = {{"schema", "tenter.result"},
                    {"version", 1},
                    {"kind", "fit"},
                    {"error_after", 0.05},
                    {"held_out_after", nullptr}};
  const std::string page = page_of(fit);
  EXPECT_NE(page.find("The fit misses 5.0"), std::string::npos);
  EXPECT_EQ(page.find("id=\"verdicts\""), std::string::npos);
  EXPECT_EQ(page.find("<svg class=\"plot\""), std::string::npos);
}

TEST(HtmlReport, WhatWasNotExcitedIsOneRowThatOpens) {
  const std::string page = page_of(fixture::result());
  EXPECT_EQ(count(page, ">NOT EXCITED</span>"), 1u);
  EXPECT_NE(page.find("plastic set</span> or <span class=\"cause\">force-camera delay"),
            std::string::npos);
  EXPECT_NE(page.find("Loops of growing height"), std::string::npos);
}

TEST(HtmlReport, ATitleThatRepeatsItsCaptureIsCut) {
  Json result = fixture::result();
  const std::string capture = result["captures"][0]["title"];
  result["figures"][0]["title"] = "stress_x, " + capture;
  EXPECT_NE(page_of(result).find("<figcaption><span>stress_x</span>"), std::string::npos);
}

TEST(HtmlReport, WithoutAnExtensionThereIsOneModel) {
  Json result = fixture::result();
  result["kind"] = "fit";
  result["model"] = result["baseline_model"];
  result["error_after"] = result["error_before"];
  const std::string page = page_of(result);
  EXPECT_EQ(page.find("series extended"), std::string::npos);
  EXPECT_EQ(page.find("baseline model</button>"), std::string::npos);
  EXPECT_NE(page.find("model</button>"), std::string::npos);
  EXPECT_EQ(page.find("\"from\">17.1"), std::string::npos);
}

TEST(HtmlReport, SurvivesWrongTypesAndMissingKeys) {
  const Json good = fixture::result();
  for (const auto& item : good.items()) {
    if (item.key() == "schema" || item.key() == "version") continue;
    for (const Json& odd : {Json(nullptr), Json(3), Json("text"), Json::array({1, "a", nullptr}),
                            Json{{"a", 1}}, Json::array({Json::array({Json::array()})})}) {
      Json result = good;
      result[item.key()] = odd;
      EXPECT_TRUE(render_html(result.dump())) << item.key() << " " << odd;
    }
    Json result = good;
    result.erase(item.key());
    EXPECT_TRUE(render_html(result.dump())) << item.key();
  }
}

TEST(HtmlReport, RefusesWhatIsNotAResult) {
  for (const char* text : {"", "{", "[]", "{}", "{\"schema\": \"tenter.model\", \"version\": 1}",
                           "{\"schema\": \"tenter.result\", \"version\": 99}"}) {
    const Expected<std::string> page = render_html(text);
    ASSERT_FALSE(page) << text;
    EXPECT_EQ(page.error().kind, ErrorKind::bad_input);
  }
}

}  // namespace
}  // namespace tenter::report
