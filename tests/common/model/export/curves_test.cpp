// SPDX-License-Identifier: Apache-2.0
#include "common/model/export/curves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/model/catalogue.h"
#include "common/model/document.h"
#include "common/model/export/term_curve.h"
#include "common/model/presets.h"

namespace tenter::model {
namespace {

Law spline_law(const std::string& name, int points, double lo, double hi) {
  Law law;
  law.name = name;
  law.range_lo = lo;
  law.range_hi = hi;
  law.parameters = default_parameters(*find_law(name), points);
  for (int j = 0; j < points; ++j)
    law.parameters[static_cast<std::size_t>(j)].value = 80.0 + 30.0 * std::sin(1.0 + 2.0 * j);
  return law;
}

// The tangent is the stress' derivative, inside the control points and beyond them.
TEST(TermCurve, StiffnessIsTheSlopeOfTheStress) {
  for (const char* name : {"linear", "constant_stress", "hermite_stiffness", "bspline_stiffness",
                           "convex_spline", "hermite_energy", "gaussian_energy"}) {
    const int points = find_law(name)->spline ? 5 : 1;
    const Law law = spline_law(name, points, -0.05, 0.4);
    const auto curve = TermCurve::of(law, Domain::membrane);
    ASSERT_TRUE(curve) << name;
    double scale = 0.0;
    double worst = 0.0;
    for (const double eps : {-0.12, -0.03, 0.01, 0.2, 0.31, 0.47}) {
      constexpr double kStep = 1e-5;
      const double slope =
          (curve->stress(law, eps + kStep) - curve->stress(law, eps - kStep)) / (2.0 * kStep);
      scale = std::max(scale, std::abs(curve->stress(law, eps)) / 0.1);
      worst = std::max(worst, std::abs(slope - curve->stiffness(law, eps)));
    }
    EXPECT_GT(scale, 10.0) << name;
    EXPECT_LT(worst, 1e-6 * scale) << name;
  }
  EXPECT_FALSE(TermCurve::of(spline_law("dahl", 0, 0.0, 0.0), Domain::membrane));
}

Model fitted() {
  Model model;
  model.name = "fitted";
  Term weft;
  weft.id = "weft, \"pulled\"";
  weft.strain.name = "green_u";
  weft.law = spline_law("bspline_stiffness", 4, 0.0, 0.4);
  for (Parameter& p : weft.law.parameters) {
    p.interval_lo = p.value - 5.0;
    p.interval_hi = p.value + 7.0;
    p.std_error = 3.0;
  }
  Term bend;
  bend.id = "bend";
  bend.strain.name = "bend_u";
  bend.law.name = "linear";
  bend.law.parameters = default_parameters(*find_law("linear"), 0, Domain::hinge);
  Term rub;
  rub.id = "rub";
  rub.strain.name = "green_u";
  rub.law.name = "dahl";
  rub.law.parameters = default_parameters(*find_law("dahl"));
  model.terms = {weft, bend, rub};
  model.strain_ranges = {{weft.id, 0.0, 0.25}};
  return model;
}

TEST(Curves, BandHoldsTheEndsOfTheIntervalsAndIsEmptyWithoutThem) {
  const Model model = fitted();
  const CurveSet set = curves_of(model, 41);
  ASSERT_EQ(set.curves.size(), 2u);
  ASSERT_EQ(set.left_out.size(), 1u);
  EXPECT_NE(set.left_out[0].find("'rub'"), std::string::npos);
  const CurveTable& weft = set.curves[0];
  EXPECT_EQ(weft.strain.front(), 0.0);
  EXPECT_EQ(weft.strain.back(), 0.4);
  EXPECT_EQ(set.curves[1].stress_unit, "N");
  EXPECT_EQ(set.curves[1].stiffness_unit, "N m");
  EXPECT_TRUE(set.curves[1].stress.lo.empty());
  // all coefficients at their upper ends: the basis of a B-spline sums to one
  const auto curve = TermCurve::of(model.terms[0].law, Domain::membrane);
  for (std::size_t i = 0; i < weft.strain.size(); ++i) {
    const double stress = curve->stress(model.terms[0].law, weft.strain[i]);
    EXPECT_NEAR(weft.stress.value[i], stress, 1e-12 * 40.0);
    EXPECT_NEAR(weft.stress.hi[i], stress + 7.0 * weft.strain[i], 1e-12 * 40.0);
    EXPECT_NEAR(weft.stress.lo[i], stress - 5.0 * weft.strain[i], 1e-12 * 40.0);
  }
  EXPECT_GT(weft.stress.hi.back() - weft.stress.lo.back(), 4.0);
}

TEST(Curves, CsvSaysWhereTheDataReached) {
  const auto csv = write_curves_csv(fitted(), 9);
  ASSERT_TRUE(csv) << csv.error().message;
  EXPECT_EQ(csv->losses.size(), 1u);
  std::istringstream lines(csv->text);
  std::string line;
  int yes = 0, no = 0, unknown = 0;
  while (std::getline(lines, line)) {
    yes += line.ends_with(",yes") ? 1 : 0;
    no += line.ends_with(",no") ? 1 : 0;
    unknown += line.ends_with(",unknown") ? 1 : 0;
  }
  EXPECT_EQ(yes, 6);  // 0 to 0.25 in steps of 0.05
  EXPECT_EQ(no, 3);
  EXPECT_EQ(unknown, 9);
  EXPECT_NE(csv->text.find("\n\"weft, \"\"pulled\"\"\",green_u,1,N/m,N/m,0,0,"), std::string::npos);
  Model only_friction = fitted();
  only_friction.terms = {only_friction.terms[2]};
  EXPECT_FALSE(write_curves_csv(only_friction));
}

TEST(Curves, JsonReadsBackWithoutLoss) {
  for (const std::string& name : preset_names()) {
    const Model model = preset(name).value();
    const Exported file = write_curves_json(model, 5);
    const auto again = read_curves_json(file.text, "curves.json");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(write_model(*again), write_model(model));
  }
  const auto json = nlohmann::json::parse(write_curves_json(fitted(), 5).text);
  EXPECT_EQ(json["terms"][0]["valid_over_strain"][1], 0.25);
  EXPECT_EQ(json["terms"][0]["curve"]["stress"]["values"].size(), 5u);
  EXPECT_TRUE(json["terms"][2]["curve"].is_null());
  const auto wrong = read_curves_json("{\"schema\": \"x\"}", "wrong.json");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("wrong.json: schema"), std::string::npos);
}

}  // namespace
}  // namespace tenter::model
