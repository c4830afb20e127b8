// SPDX-License-Identifier: GPL-3.0-or-later
// Spirals and cantilevers, from CSV to the job's documents.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/report/html_report.h"
#include "common/report/residual_file.h"
#include "common/report/text_report.h"
#include "tests/server/jobs/friction_test/friction_job_fixture.h"
#include "tests/twin/friction/hanging_strip.h"

namespace tenter::jobs {
namespace {

using nlohmann::json;

json strips_description(const twin::FrictionSample& sample) {
  json d = json::parse(R"({
    "schema": "tenter.describe", "version": 1, "kind": "strip_profiles", "title": "Strips, warp",
    "columns": {
      "strip": {"is": "run"},
      "x_mm": {"channel": "x", "quantity": "position", "unit": "mm", "point": "strip",
               "coordinate": "x", "sigma": 0.02},
      "y_mm": {"channel": "y", "quantity": "position", "unit": "mm", "point": "strip",
               "coordinate": "y", "sigma": 0.02},
      "radius_mm": {"channel": "radius", "quantity": "length", "unit": "mm"},
      "length_mm": {"channel": "length", "quantity": "length", "unit": "mm"},
      "sense": {"quantity": "other", "unit": "1"}
    },
    "specimen": {"name": "strips", "width": {"value": 25, "unit": "mm"},
                 "axis_angle": {"value": 90, "unit": "degree"}},
    "protocol": {"name": "spirals", "history": "virgin_each_run"},
    "provenance": {"source": "twin", "synthetic": true}
  })");
  d["specimen"]["material"] = sample.name;
  d["specimen"]["area_density"] = {{"value", sample.density_kg_m2}, {"unit", "kg/m2"}};
  return d;
}

struct Rolled {
  double radius_mm = 0.0;  ///< 0: a cantilever
  int sense = 1;
  bool is_mirrored = false;  ///< photographed from the other side
};

std::string table_of(const twin::FrictionSample& sample, const std::vector<Rolled>& strips) {
  std::ostringstream csv;
  csv.precision(12);
  csv << "strip,x_mm,y_mm,radius_mm,length_mm,sense\n";
  for (std::size_t i = 0; i < strips.size(); ++i) {
    twin::StripPlan plan;
    plan.radius_m = 1e-3 * strips[i].radius_mm;
    plan.hinges = 120;
    if (plan.radius_m == 0.0) {
      plan.clamp_angle_rad = twin::kCantileverAngle;
      plan.length_m = 0.06;
    }
    const double side = strips[i].is_mirrored ? -1e3 : 1e3;
    for (const twin::StripPoint& p :
         twin::photographed(twin::resting_strip(sample, plan), 2e-5, 7 + i))
      csv << i + 1 << ',' << side * p.x_m << ',' << 1e3 * p.y_m << ',' << strips[i].radius_mm << ','
          << 1e3 * plan.length_m << ',' << strips[i].sense << '\n';
  }
  return csv.str();
}

const twin::FrictionSample& doublecloth() {
  return twin::bending_samples()[1];
}

using StripsJob = FrictionJob;

TEST_F(StripsJob, SpiralsAndCantileversGiveTheTable) {
  const twin::FrictionSample& cloth = doublecloth();
  import("strips",
         table_of(cloth, {{0.0},
                          {5.0},
                          {10.0, 1, true},
                          {16.0},
                          {23.0, 1, true},
                          {31.5},
                          { 50.0 }}),
         strips_description(cloth).dump());
  const auto result = run({{"protocol", "spiral"}});
  ASSERT_TRUE(result) << result.error().message;
  ASSERT_EQ((*result)["friction_test"]["parts"].size(), 1U);
  const json& part = (*result)["friction_test"]["parts"][0];
  EXPECT_EQ(part["direction"], "warp");
  EXPECT_EQ(part["sense"], "positive");
  EXPECT_EQ(part["spirals"], 6);
  EXPECT_EQ(part["cantilevers"], 1);
  EXPECT_NEAR(part["noise"].get<double>(), 2e-5, 0.5e-5);
  const double truth[] = {cloth.k1, cloth.k2, cloth.a, cloth.b, cloth.tau};
  int told = 0;
  for (std::size_t k = 0; k < 5; ++k) {
    const json& number = part["numbers"][k];
    if (!number["told"].get<bool>()) {
      EXPECT_TRUE(number["value"].is_null());
      EXPECT_FALSE(number["words"].get<std::string>().empty());
      continue;
    }
    ++told;
    const double width = number["interval"][1].get<double>() - number["interval"][0].get<double>();
    EXPECT_LT(std::abs(number["value"].get<double>() - truth[k]), width) << number.dump();
  }
  EXPECT_GE(told, 3);
  EXPECT_NEAR(part["numbers"][2]["value"].get<double>(), cloth.a, 0.05 * cloth.a);
  EXPECT_GT(part["cantilever"]["k1"].get<double>(), 1.3 * cloth.k1);
  EXPECT_LT((*result)["error_after"].get<double>(), 0.1);

  const auto tables = report::read_residuals((folder_ / "staging" / "residuals.h5").string());
  ASSERT_TRUE(tables);
  ASSERT_EQ(tables->size(), 2U);
  const report::ResidualTable& table = tables->front();
  EXPECT_EQ(table.channel, "bend_v_positive");
  EXPECT_EQ(tables->back().channel, "bend_v_positive_torque");
  EXPECT_EQ(table.size(), part["samples"].get<std::size_t>());
  double largest = 0.0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    largest = std::max(largest, table.measured[i]);
    EXPECT_LT(std::abs(table.measured[i] - table.predicted_extended[i]), 12.0 * table.sigma[i]);
  }
  EXPECT_GT(largest, 100.0);

  std::vector<std::string> kinds;
  for (const json& figure : (*result)["figures"]) kinds.push_back(figure["kind"]);
  EXPECT_EQ(kinds, (std::vector<std::string>{"strip_profile", "curvature", "unloading",
                                             "residual_torque", "residual_strain"}));
  const std::string first = text_;
  EXPECT_TRUE(run({{"protocol", "spiral"}}));
  EXPECT_EQ(text_, first);
  const auto page = report::render_html(text_);
  ASSERT_TRUE(page) << page.error().message;
  for (const char* piece : {"id=\"friction\"", "id=\"test\"", "id=\"residuals\"",
                            "Warp, positive sense", "Curvature along the strips", "strain 3 kappa"})
    EXPECT_NE(page->find(piece), std::string::npos) << piece;
  const auto words = report::render_text(text_);
  ASSERT_TRUE(words);
  EXPECT_NE(words->find("6 spirals, 1 cantilevers"), std::string::npos);
}

TEST_F(StripsJob, SensesAreFittedApart) {
  const twin::FrictionSample& cloth = doublecloth();
  twin::FrictionSample other = cloth;
  other.a *= 1.5;
  const std::vector<double> radii = {5.0, 16.0, 50.0};
  std::vector<Rolled> to_one_face, to_the_other;
  for (const double radius : radii) {
    to_one_face.push_back({radius, 1});
    to_the_other.push_back({radius, -1});  // and photographed from the other end
  }
  import("one", table_of(cloth, to_one_face), strips_description(cloth).dump());
  import("other", table_of(other, to_the_other), strips_description(cloth).dump());
  const auto result = run({{"protocol", "spiral"}, {"samples", 6}});
  ASSERT_TRUE(result) << result.error().message;
  const json& parts = (*result)["friction_test"]["parts"];
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[1]["sense"], "negative");
  const auto a_of = [&](std::size_t k) { return parts[k]["numbers"][2]["value"].get<double>(); };
  EXPECT_NEAR(a_of(1) / a_of(0), 1.5, 0.1);
  EXPECT_EQ((*result)["parameters"][0]["name"], "positive.elastic.k1");
  EXPECT_EQ((*result)["figures"].size(), 10U);
}

TEST_F(StripsJob, SaysWhatFewRadiiLack) {
  const twin::FrictionSample& cloth = doublecloth();
  import("strips", table_of(cloth, {{80.0}, { 80.0 }}), strips_description(cloth).dump());
  const auto result = run({{"protocol", "spiral"}});
  ASSERT_TRUE(result) << result.error().message;
  const auto page = report::render_html(text_);
  const auto words = report::render_text(text_, {.width = 400});
  ASSERT_TRUE(page && words);
  const double truth[] = {cloth.k1, cloth.k2, cloth.a, cloth.b, cloth.tau};
  const json& numbers = (*result)["friction_test"]["parts"][0]["numbers"];
  int untold = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const json& number = numbers[k];
    if (number["told"].get<bool>()) {
      const double width =
          number["interval"][1].get<double>() - number["interval"][0].get<double>();
      EXPECT_LT(std::abs(number["value"].get<double>() - truth[k]), width) << number.dump();
      continue;
    }
    ++untold;
    EXPECT_TRUE(number["value"].is_null());
    const std::string why = number["words"].get<std::string>();
    EXPECT_NE(why.find(number["name"] == "k1" ? "no cantilever" : "of 1 radius only"),
              std::string::npos)
        << why;
    EXPECT_NE(page->find(why), std::string::npos);
    EXPECT_NE(words->find(why), std::string::npos);
  }
  EXPECT_GE(untold, 2) << (*result)["friction_test"].dump(1);
}

TEST_F(StripsJob, CantileversTellStiffnessAndNothingOfFriction) {
  const twin::FrictionSample& cloth = doublecloth();
  import("strips", table_of(cloth, {{0.0}, {0.0}, { 5.0 }}), strips_description(cloth).dump());
  const auto result = run({{"protocol", "cantilever"}});
  ASSERT_TRUE(result) << result.error().message;
  const json& part = (*result)["friction_test"]["parts"][0];
  EXPECT_TRUE(part["numbers"][0]["told"].get<bool>()) << part.dump(1);
  EXPECT_GT(part["numbers"][0]["value"].get<double>(), 1.3 * cloth.k1);
  for (const std::size_t k : {2U, 3U, 4U}) {
    EXPECT_FALSE(part["numbers"][k]["told"].get<bool>());
    EXPECT_NE(part["numbers"][k]["words"].get<std::string>().find("never rolled"),
              std::string::npos);
  }
  EXPECT_NE(text_.find("1 spiral passed over"), std::string::npos);
}

TEST_F(StripsJob, SaysWhatIsWrong) {
  const twin::FrictionSample& cloth = doublecloth();
  import("strips", table_of(cloth, {{ 0.0 }}), strips_description(cloth).dump());
  EXPECT_NE(refusal({{"protocol", "spiral"}}).find("no strip was rolled"), std::string::npos);
  EXPECT_NE(refusal({{"protocol", "cantilever"}, {"samples", 0}}).find("options.samples"),
            std::string::npos);
  EXPECT_NE(refusal({{"protocol", "cantilever"}, {"seed", 1}}).find("options.seed"),
            std::string::npos);
  EXPECT_NE(refusal({{"protocol", "hanging-weights"}}).find("hanging weights"), std::string::npos);
  EXPECT_NE(refusal(json::object()).find("options.protocol"), std::string::npos);
  json weft = strips_description(cloth);
  weft["specimen"]["axis_angle"]["value"] = 0;
  import("weft", table_of(cloth, {{ 5.0 }}), weft.dump());
  EXPECT_NE(refusal({{"protocol", "spiral"}}).find("another direction"), std::string::npos);
}

}  // namespace
}  // namespace tenter::jobs
