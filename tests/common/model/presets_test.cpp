// SPDX-License-Identifier: Apache-2.0
#include "common/model/presets.h"

#include <gtest/gtest.h>

#include "common/model/catalogue.h"
#include "common/model/document.h"

namespace tenter::model {
namespace {

TEST(Presets, EachParsesUnderItsOwnNameAndRoundTrips) {
  ASSERT_EQ(preset_names().size(), 28u);
  for (const std::string& name : preset_names()) {
    const Expected<Model> model = preset(name);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->name, name);
    EXPECT_FALSE(model->description.empty());
    const std::string text = write_model(*model);
    const Expected<Model> again = parse_model(text, name);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(write_model(*again), text);
  }
}

/// Presets of one measured material say its own values.
bool is_material(const std::string& name) {
  for (const char* material : {"cotton", "spandex", "polyester", "felt", "doublecloth", "paper"})
    if (name == material) return true;
  return false;
}

// Values are the catalogue's for membranes; bending, solids and materials say their own.
TEST(Presets, BoundsAndUnitsAreTheCatalogues) {
  for (const std::string& name : preset_names()) {
    const Model model = preset(name).value();
    for (const Term& term : model.terms) {
      const LawRow& law = *find_law(term.law.name);
      const StrainRow& strain = *find_strain(term.strain.name);
      const bool is_membrane = name.rfind("solid", 0) != 0 && strain.at_point;
      const auto defaults =
          default_parameters(law, static_cast<int>(term.law.parameters.size()), strain.domain);
      ASSERT_EQ(term.law.parameters.size(), defaults.size());
      for (std::size_t i = 0; i < defaults.size(); ++i) {
        EXPECT_EQ(term.law.parameters[i].unit, defaults[i].unit) << name << " " << term.id;
        if (!is_membrane) continue;
        EXPECT_EQ(term.law.parameters[i].lower, defaults[i].lower) << name << " " << term.id;
        EXPECT_EQ(term.law.parameters[i].upper, defaults[i].upper) << name << " " << term.id;
        if (is_material(name)) continue;
        EXPECT_EQ(term.law.parameters[i].value, defaults[i].value) << name << " " << term.id;
      }
    }
  }
}

TEST(Presets, SplineVariantsHaveFivePointsAndLeaveTheRangeToTheFit) {
  for (const std::string& name : preset_names()) {
    if (name.find("_spline") == std::string::npos) continue;
    int splines = 0;
    const Model model = preset(name).value();
    for (const Term& term : model.terms) {
      if (!find_law(term.law.name)->spline) continue;
      ++splines;
      EXPECT_EQ(term.law.name, "bspline_stiffness");  // stays non-negative, unlike a Hermite spline
      EXPECT_EQ(term.law.parameters.size(), 5u);
      EXPECT_EQ(term.law.range_lo, term.law.range_hi);
    }
    EXPECT_GE(splines, 1) << name;
  }
}

TEST(Presets, SplinesWithFrictionAreTheSplinesBesideTheFriction) {
  const std::vector<Term> splines = preset("cloth_stvk_spline")->terms;
  const std::vector<Term> linear = preset("cloth_stvk_friction")->terms;
  const std::vector<Term> both = preset("cloth_stvk_spline_friction")->terms;
  ASSERT_EQ(both.size(), splines.size() + 3);
  for (std::size_t i = 0; i < both.size(); ++i) {
    // the linear model has as many elastic terms, its frictions behind them
    const Term& expected = i < splines.size() ? splines[i] : linear[i];
    EXPECT_EQ(both[i].id, expected.id);
    EXPECT_EQ(both[i].strain.name, expected.strain.name);
    EXPECT_EQ(both[i].law.name, expected.law.name);
    EXPECT_EQ(both[i].law.name == "dahl", i >= splines.size());
    ASSERT_EQ(both[i].law.parameters.size(), expected.law.parameters.size());
    for (std::size_t k = 0; k < expected.law.parameters.size(); ++k) {
      EXPECT_EQ(both[i].law.parameters[k].name, expected.law.parameters[k].name);
      EXPECT_EQ(both[i].law.parameters[k].value, expected.law.parameters[k].value);
      EXPECT_EQ(both[i].law.parameters[k].fixed, expected.law.parameters[k].fixed);
    }
  }
}

TEST(Presets, UnknownNameListsTheKnown) {
  const Expected<Model> model = preset("jelly");
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, ErrorKind::not_found);
  EXPECT_NE(model.error().message.find("jelly"), std::string::npos);
  EXPECT_NE(model.error().message.find("stvk_orthotropic"), std::string::npos);
}

}  // namespace
}  // namespace tenter::model
