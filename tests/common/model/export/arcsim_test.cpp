// SPDX-License-Identifier: Apache-2.0
#include "common/model/export/arcsim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/model/catalogue.h"
#include "common/model/document.h"
#include "common/model/presets.h"

namespace tenter::model {
namespace {

using Json = nlohmann::json;

/// Energy density of a membrane as the simulator has it (arcsim.h), N/m.
double arcsim_energy(const std::vector<double>& c, double g11, double g22, double g12) {
  return c[0] * g11 * g11 + 2.0 * c[1] * g11 * g22 + c[2] * g22 * g22 + 2.0 * c[3] * g12 * g12;
}

// Linear isotropic St. Venant-Kirchhoff: lambda/2 tr(E)^2 + mu tr(E^2) on both sides.
TEST(Arcsim, LinearModelsKeepTheirEnergy) {
  Model model = preset("stvk_isotropic").value();
  model.terms[0].law.parameters[0].value = 130.0;  // on the trace: lambda + mu
  model.terms[1].law.parameters[0].value = 40.0;   // on the deviator: mu
  const auto file = write_arcsim(model, 0.2);
  ASSERT_TRUE(file) << file.error().message;
  const Json json = Json::parse(file->text);
  EXPECT_EQ(json["density"], 0.2);
  const double mu = 40.0, lambda = 90.0;
  const double g11 = 0.13, g22 = -0.04, g12 = 0.07;
  const double expected =
      lambda / 2.0 * std::pow(g11 + g22, 2) + mu * (g11 * g11 + g22 * g22 + 2.0 * g12 * g12);
  for (const auto& row : json["stretching"])
    EXPECT_NEAR(arcsim_energy(row.get<std::vector<double>>(), g11, g22, g12), expected,
                1e-12 * expected);
  EXPECT_EQ(file->losses.size(), 3u);  // no bending
}

Model splines() {
  Model model = preset("cloth_stvk_spline").value();
  int j = 0;
  for (Term& term : model.terms) {
    term.law.range_hi = term.strain.name.starts_with("bend") ? 150.0 : 0.3;
    for (Parameter& p : term.law.parameters) p.value *= 1.0 + 0.3 * std::sin(++j);
  }
  return model;
}

TEST(Arcsim, SplinesLoseWhatIsBetweenTheSamplesAndSaySo) {
  const auto file = write_arcsim(splines(), 0.2);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_GE(file->losses.size(), 6u);
  EXPECT_NE(file->losses[0].find("weft"), std::string::npos);
  const Json json = Json::parse(file->text);
  EXPECT_EQ(json["stretching"].size(), 6u);
  // at rest a clamped B-spline is its first coefficient
  EXPECT_NEAR(json["stretching"][0][0].get<double>(),
              0.5 * splines().terms[0].law.parameters[0].value, 1e-12 * 50.0);
  EXPECT_NEAR(json["bending"][2][0].get<double>(),
              12.0 * splines().terms[3].law.parameters[0].value, 1e-12 * 1e-4);
}

// What was read from a file is written and read again without a change.
TEST(Arcsim, RoundTrip) {
  const std::string text = R"({"density": 0.324, "damping": 0,
    "stretching": [[205, 10, 1013, 53], [232, 10, 1052, 65], [224, 10, 1054, 67],
                   [226, 10, 1059, 84], [226, 10, 1058, 75], [225, 10, 1051, 72]],
    "bending": [[6.4e-5, 6.0e-5, 6.1e-5, 6.2e-5, 2.0e-5], [7.3e-5, 6e-5, 6.1e-5, 6.8e-5, 3.6e-5],
                [9.7e-5, 9.7e-5, 9.7e-5, 9.7e-5, 9.7e-5]]})";
  const auto first = read_arcsim(text, "denim.json", "denim");
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(first->area_density_kg_m2, 0.324);
  EXPECT_EQ(first->losses.size(), 3u);  // c11, c22 and c33 depend on the angle, c12 is constant
  const auto file = write_arcsim(first->model, first->area_density_kg_m2);
  ASSERT_TRUE(file) << file.error().message;
  const auto again = read_arcsim(file->text, "denim.json", "denim");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(again->losses.empty());
  ASSERT_EQ(again->model.terms.size(), 7u);
  for (std::size_t t = 0; t < again->model.terms.size(); ++t) {
    const Law& a = first->model.terms[t].law;
    const Law& b = again->model.terms[t].law;
    EXPECT_EQ(a.name, b.name) << first->model.terms[t].id;
    ASSERT_EQ(a.parameters.size(), b.parameters.size());
    for (std::size_t j = 0; j < a.parameters.size(); ++j) {
      EXPECT_GT(a.parameters[j].value, 0.0);
      EXPECT_NEAR(a.parameters[j].value, b.parameters[j].value, 1e-14 * a.parameters[j].value);
    }
  }
  EXPECT_EQ(again->model.terms[4].law.name, "linear");  // bend_weft: the row of equal values
}

TEST(Arcsim, RefusesInOneSentence) {
  const auto message = [](const Model& model) {
    const auto file = write_arcsim(model, 0.2);
    return file ? std::string() : file.error().message;
  };
  EXPECT_NE(message(preset("cloth_soft").value()).find("term 'weft'"), std::string::npos);
  EXPECT_NE(message(preset("solid_stvk").value()).find("not made of Green strains"),
            std::string::npos);
  Model negative = preset("stvk_isotropic").value();
  negative.terms[1].law.parameters[0].value = 1000.0;  // coupling below zero
  EXPECT_NE(message(negative).find("negative stiffness"), std::string::npos);
  Model limited = preset("stvk_diagonal").value();
  limited.limits.push_back({"lock", {}, 5.0, "J/m^2"});
  EXPECT_NE(message(limited).find("limits an energy"), std::string::npos);
  EXPECT_FALSE(write_arcsim(preset("stvk_diagonal").value(), 0.0));
  EXPECT_FALSE(read_arcsim("{\"density\": 0.1}", "x.json", "x"));
  const auto few = read_arcsim("{\"density\": 0.1, \"stretching\": [], \"bending\": []}", "x", "x");
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().message.find("stretching: must hold 6 samples"), std::string::npos);
}

TEST(Arcsim, NegativeNumbersOfAFileCountAsZero) {
  const std::string text = R"({"density": 0.2,
    "stretching": [[31, -12, 44, 31], [78, 26, 268, 27], [67, 77, 182, -14],
                   [113, 54, 175, 44], [144, 111, 138, -29], [143, 49, 191, 39]],
    "bending": [[3e-5, 3e-5, 3e-5, 3e-5, 3e-5], [3e-5, 3e-5, 3e-5, 3e-5, 3e-5],
                [3e-5, 3e-5, 3e-5, 3e-5, 3e-5]]})";
  const auto read = read_arcsim(text, "roma.json", "roma");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->losses.size(), 5u);
  EXPECT_EQ(read->losses[0].substr(0, 2), "3 ");
  EXPECT_NEAR(read->model.terms[2].law.parameters[0].value, 2.0 * (26 + 77 + 54 + 111 + 49) / 6.0,
              1e-9);
  EXPECT_TRUE(parse_model(write_model(read->model), "again"));
}

}  // namespace
}  // namespace tenter::model
