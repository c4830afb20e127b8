// SPDX-License-Identifier: Apache-2.0
#include "common/model/catalogue.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

namespace tenter::model {
namespace {

TEST(Catalogue, NamesAreUniqueAndFindable) {
  std::set<std::string_view> names;
  std::set<std::pair<std::string_view, Seen>> corrections;
  for (const StrainRow& row : strain_catalogue()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(find_strain(row.name), &row);
    EXPECT_FALSE(row.words.empty());
  }
  for (const LawRow& row : law_catalogue()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(find_law(row.name), &row);
    EXPECT_FALSE(row.words.empty());
  }
  for (const CorrectionRow& row : correction_catalogue()) {
    EXPECT_TRUE(corrections.insert({row.name, row.seen}).second) << row.name;
    EXPECT_EQ(find_correction(row.name, row.seen), &row);
    EXPECT_FALSE(row.words.empty());
  }
  EXPECT_EQ(find_law("magic"), nullptr);
  EXPECT_EQ(find_strain(""), nullptr);
}

TEST(Catalogue, DefaultsLieWithinTheirBounds) {
  const auto check = [](const ParameterRow& row) {
    EXPECT_FALSE(row.unit.empty()) << row.name;
    EXPECT_GE(row.value, row.lower.value_or(row.value)) << row.name;
    EXPECT_LE(row.value, row.upper.value_or(row.value)) << row.name;
  };
  for (const LawRow& law : law_catalogue()) {
    ASSERT_FALSE(law.parameters.empty());
    for (const ParameterRow& row : law.parameters) check(row);
    if (law.spline) {
      EXPECT_EQ(law.parameters.size(), 1u) << law.name;
      EXPECT_GE(law.min_points, 1) << law.name;
    }
    EXPECT_TRUE(law.path_dependent || !law.rate_dependent) << law.name;
  }
  for (const CorrectionRow& correction : correction_catalogue())
    for (const ParameterRow& row : correction.parameters) check(row);
}

TEST(Catalogue, EveryParameterHasAUnitInEveryDomain) {
  for (const LawRow& law : law_catalogue())
    for (const ParameterRow& row : law.parameters)
      for (const Domain domain : {Domain::membrane, Domain::edge, Domain::hinge, Domain::solid}) {
        const ParameterRow there = in_domain(row, domain);
        EXPECT_FALSE(there.unit.empty())
            << law.name << "." << row.name << " in " << words_of(domain);
        EXPECT_EQ(there.lower.has_value(), row.lower.has_value());
        if (domain == Domain::membrane || domain == Domain::edge) {
          EXPECT_EQ(there.unit, row.unit);
          EXPECT_EQ(there.value, row.value);
        }
      }
}

TEST(Catalogue, OnlyMeasuresOfMembranesAndSpringsAnswerAMaterialPoint) {
  for (const StrainRow& row : strain_catalogue()) {
    if (row.domain == Domain::hinge || row.domain == Domain::solid) {
      EXPECT_FALSE(row.at_point) << row.name;
    }
    if (row.domain == Domain::membrane) {
      EXPECT_TRUE(row.at_point) << row.name;
    }
    EXPECT_EQ(row.domain == Domain::solid, row.name.substr(0, 6) == "solid_") << row.name;
  }
}

TEST(Catalogue, SplineParametersAreNumberedFromOne) {
  const std::vector<Parameter> points = default_parameters(*find_law("hermite_stiffness"), 3);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[0].name, "k1");
  EXPECT_EQ(points[2].name, "k3");
  EXPECT_EQ(points[2].unit, "N/m");
  EXPECT_EQ(points[2].lower, 0.0);
}

TEST(Catalogue, SplineRangeNotChosenYetHasADefault) {
  Law law;
  law.name = "hermite_stiffness";
  EXPECT_EQ(spline_range(law), std::make_pair(0.0, 0.5));
  EXPECT_EQ(spline_range(law, Domain::hinge), std::make_pair(-300.0, 300.0));
  law.range_lo = -0.1;
  law.range_hi = 1.2;
  EXPECT_EQ(spline_range(law), std::make_pair(-0.1, 1.2));
}

TEST(Catalogue, JsonSchemaListsTheSameNames) {
  std::ifstream file(TENTER_MODEL_SCHEMA);
  const nlohmann::json schema = nlohmann::json::parse(file);
  const auto& term = schema["$defs"]["term"]["properties"];
  std::vector<std::string> strains, laws, corrections;
  for (const StrainRow& row : strain_catalogue()) strains.emplace_back(row.name);
  for (const LawRow& row : law_catalogue()) laws.emplace_back(row.name);
  for (const CorrectionRow& row : correction_catalogue())
    if (row.seen == Seen::curves || !find_correction(row.name)) corrections.emplace_back(row.name);
  EXPECT_EQ(term["strain"]["properties"]["name"]["enum"].get<std::vector<std::string>>(), strains);
  EXPECT_EQ(term["law"]["properties"]["name"]["enum"].get<std::vector<std::string>>(), laws);
  EXPECT_EQ(
      schema["$defs"]["correction"]["properties"]["type"]["enum"].get<std::vector<std::string>>(),
      corrections);
}

}  // namespace
}  // namespace tenter::model
