// SPDX-License-Identifier: GPL-3.0-or-later
// Laws without memory: linear, bilinear, exponential fibre and the splines.
#include <gtest/gtest.h>

#include <cmath>

#include "common/model/catalogue.h"
#include "server/mechanics/law.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/law_checks.h"

namespace tenter::mechanics {
namespace {

using testing::check_law;
using testing::law_with;
using testing::Numbers;
using testing::values_of;

LawOutput evaluate(const Law& law, const std::vector<double>& parameters,
                   const std::vector<double>& strain) {
  LawOutput out{};
  law.evaluate({strain.data(), parameters.data(), nullptr, 0.0}, out);
  return out;
}

std::shared_ptr<const Law> made(const model::Law& description, int strains = 1) {
  const auto law = make_law(description, strains);
  EXPECT_TRUE(law) << description.name;
  return *law;
}

/// Composite Gauss-Legendre of order 4 from 0 to `end`.
template <class Function>
double integral(Function f, double end) {
  constexpr int kPieces = 400;
  constexpr double kNode = 0.5773502691896257;
  double sum = 0.0;
  const double half = 0.5 * end / kPieces;
  for (int i = 0; i < kPieces; ++i) {
    const double centre = (2 * i + 1) * half;
    sum += half * (f(centre - kNode * half) + f(centre + kNode * half));
  }
  return sum;
}

const std::vector<double> kFive = {120.0, 40.0, 300.0, 90.0, 500.0};

TEST(ElasticLaws, HoldTheDerivativesOfALaw) {
  check_law({.words = "linear", .law = law_with("linear", {120.0})});
  check_law({.words = "linear on two", .law = law_with("linear", {120.0}), .strains = 2});
  check_law({.words = "linear stiffness", .law = law_with("linear_stiffness", {120.0, 300.0})});
  check_law({.words = "bilinear", .law = law_with("bilinear", {-35.0}), .strains = 2});
  check_law({.words = "cross-modal", .law = law_with("cross_modal", {9000.0}), .strains = 2});
  for (const int strains : {1, 2})
    check_law({.words = "strain limit",
               .law = law_with("strain_limit", {250.0, 0.03}),
               .strains = strains,
               .kinks = {-0.03, 0.03}});
  check_law({.words = "exponential fibre", .law = law_with("exponential_fibre", {80.0, 60.0})});
  for (const double alpha : {2.0, 1.3, 9.0, -4.0, 1e-3})
    for (const int strains : {1, 2, 3})
      check_law({.words = "ogden " + std::to_string(alpha),
                 .law = law_with("ogden", {alpha < 0.0 ? -70.0 : 70.0, alpha}),
                 .strains = strains,
                 .lo = -0.3,
                 .hi = 0.6,
                 .finest = 1e-4});
  check_law({.words = "constant stress",
             .law = law_with("constant_stress", {12.0}),
             .stressed_at_rest = true,
             .has_tangent = false});
  const std::vector<double> w = {0.6, 0.1, 0.05, 0.4, 1.1};
  check_law({.words = "hermite energy inside",
             .law = law_with("hermite_energy", w, -0.06, 0.11),
             .finest = 2e-5,
             .kinks = {-0.0175, 0.025, 0.0675},
             .stressed_at_rest = true});
  check_law({.words = "hermite energy beyond its points",
             .law = law_with("hermite_energy", w, 0.01, 0.05),
             .finest = 2e-5,
             .kinks = {0.01, 0.02, 0.03, 0.04, 0.05},
             .stressed_at_rest = true});
  check_law({.words = "gaussian energy",
             .law = law_with("gaussian_energy", w, -0.06, 0.11),
             .finest = 2e-5,
             .stressed_at_rest = true});
  check_law({.words = "gaussian energy of two strains",
             .law = law_with("gaussian_energy_2", {0.6, 0.1, 0.3, 0.4, 0.1, 0.2, 0.7, 0.2, 0.9},
                             -0.06, 0.11),
             .strains = 2,
             .finest = 2e-5,
             .stressed_at_rest = true});
  for (const char* name : {"hermite_stiffness", "bspline_stiffness", "convex_spline"}) {
    check_law({.words = std::string(name) + " inside",
               .law = law_with(name, kFive, -0.06, 0.11),
               .finest = 2e-5,
               .kinks = {-0.0175, 0.025, 0.0675}});
    check_law({.words = std::string(name) + " beyond its points",
               .law = law_with(name, kFive, 0.01, 0.05),
               .finest = 2e-5,
               .kinks = {0.01, 0.02, 0.03, 0.04, 0.05}});
    check_law({.words = std::string(name) + " on two",
               .law = law_with(name, kFive, -0.06, 0.11),
               .strains = 2,
               .finest = 2e-5,
               .kinks = {-0.0175, 0.025, 0.0675}});
  }
}

TEST(ElasticLaws, EnergyIsTheIntegralOfTheStress) {
  const std::vector<model::Law> laws = {
      law_with("linear", {120.0}),
      law_with("exponential_fibre", {80.0, 60.0}),
      law_with("hermite_stiffness", kFive, -0.02, 0.06),
      law_with("bspline_stiffness", kFive, -0.02, 0.06),
      law_with("convex_spline", kFive, -0.02, 0.06),
      law_with("convex_spline", kFive, 0.02, 0.06),
      law_with("constant_stress", {7.0}),
      law_with("ogden", {70.0, 3.0}),
      law_with("hermite_energy", {0.6, 0.1, 0.05, 0.4, 1.1}, -0.02, 0.06),
      law_with("gaussian_energy", {0.6, 0.1, 0.05, 0.4, 1.1}, -0.02, 0.06),
  };
  for (const model::Law& description : laws) {
    const auto law = made(description);
    const std::vector<double> values = values_of(description);
    for (const double end : {-0.05, -0.01, 0.03, 0.06, 0.1}) {
      const double work =
          integral([&](double e) { return evaluate(*law, values, {e}).stress[0]; }, end);
      ASSERT_GT(std::abs(work), 1e-4) << description.name;
      EXPECT_NEAR(evaluate(*law, values, {end}).energy / work, 1.0, 1e-6)
          << description.name << " to " << end;
    }
  }
}

TEST(SplineLaws, WithEqualCoefficientsAreTheLinearLaw) {
  for (const char* name : {"hermite_stiffness", "bspline_stiffness", "convex_spline"}) {
    for (const int points : {4, 5, 9}) {
      const model::Law description =
          law_with(name, std::vector<double>(static_cast<std::size_t>(points), 130.0), -0.01, 0.08);
      const auto law = made(description);
      for (const double e : {-0.05, -0.01, 0.0, 0.013, 0.0799, 0.2}) {
        const LawOutput out = evaluate(*law, values_of(description), {e});
        EXPECT_NEAR(out.stress[0], 130.0 * e, 1e-10) << name << " of " << points << " at " << e;
        EXPECT_NEAR(out.tangent[0][0], 130.0, 1e-8) << name;
        EXPECT_NEAR(out.energy, 65.0 * e * e, 1e-12) << name;
      }
    }
  }
  const model::Law one = law_with("hermite_stiffness", {130.0});
  EXPECT_NEAR(evaluate(*made(one), {130.0}, {0.07}).stress[0], 9.1, 1e-12);
}

TEST(SplineLaws, HermitePassesThroughItsPoints) {
  const model::Law description = law_with("hermite_stiffness", kFive, 0.0, 0.08);
  const auto law = made(description);
  for (int i = 1; i < 5; ++i) {
    const double e = 0.02 * i;
    EXPECT_NEAR(evaluate(*law, kFive, {e}).stress[0] / e, kFive[static_cast<std::size_t>(i)], 1e-9);
  }
}

TEST(SplineLaws, AreContinuousAtTheirPoints) {
  for (const char* name : {"hermite_stiffness", "bspline_stiffness", "convex_spline"}) {
    const model::Law description = law_with(name, kFive, -0.02, 0.06);
    const auto law = made(description);
    for (const double e : {-0.02, 0.0, 0.02, 0.04, 0.06}) {
      constexpr double kGap = 1e-9;
      const LawOutput below = evaluate(*law, kFive, {e - kGap});
      const LawOutput above = evaluate(*law, kFive, {e + kGap});
      EXPECT_NEAR(below.energy, above.energy, 1e-7) << name << " at " << e;
      EXPECT_NEAR(below.stress[0], above.stress[0], 1e-5) << name << " at " << e;
      const bool inside = e > -0.02 && e < 0.06;
      if (inside) {
        EXPECT_NEAR(below.tangent[0][0], above.tangent[0][0], 1e-3) << name << " at " << e;
      }
    }
  }
}

TEST(SplineLaws, StayNonNegativeWhereTheirCoefficientsAre) {
  Numbers numbers(7);
  for (int sample = 0; sample < 50; ++sample) {
    std::vector<double> values;
    for (int i = 0; i < 8; ++i)
      values.push_back(numbers.between(0.0, 1.0) < 0.5 ? 0.0 : numbers.between(0.0, 400.0));
    const model::Law stiffness = law_with("bspline_stiffness", values, -0.02, 0.1);
    const model::Law convex = law_with("convex_spline", values, -0.02, 0.1);
    for (double e = -0.05; e < 0.15; e += 0.00137) {
      EXPECT_GE(evaluate(*made(stiffness), values, {e}).stress[0] * e, -1e-12);
      EXPECT_GE(evaluate(*made(convex), values, {e}).tangent[0][0], -1e-9);
    }
  }
}

TEST(HermiteEnergyLaw, PassesThroughItsPointsUpToTheRestEnergy) {
  const std::vector<double> w = {0.6, 0.1, 0.05, 0.4, 1.1};
  const auto law = made(law_with("hermite_energy", w, -0.02, 0.06));
  for (int i = 0; i < 5; ++i)
    EXPECT_NEAR(evaluate(*law, w, {-0.02 + 0.02 * i}).energy, w[static_cast<std::size_t>(i)] - w[1],
                1e-14);
}

TEST(HermiteEnergyLaw, OfEvenSamplesOfAParabolaIsTheLinearLawInside) {
  std::vector<double> w;
  for (int i = 0; i < 7; ++i) w.push_back(50.0 * std::pow(-0.03 + 0.02 * i, 2));
  const auto law = made(law_with("hermite_energy", w, -0.03, 0.09));
  for (const double e : {-0.005, 0.0, 0.013, 0.05, 0.0699}) {
    EXPECT_NEAR(evaluate(*law, w, {e}).stress[0], 100.0 * e, 1e-12);
    EXPECT_NEAR(evaluate(*law, w, {e}).tangent[0][0], 100.0, 1e-9);
  }
}

TEST(GaussianEnergyLaw, IsTheSumOfItsGaussians) {
  const std::vector<double> w = {0.6, 0.1, 0.3, 0.4, 0.1, 0.2, 0.7, 0.2, 0.9};
  const auto law = made(law_with("gaussian_energy_2", w, -0.1, 0.3), 2);
  const auto sum = [&](double x, double y) {
    double s = 0.0;
    for (int j = 0; j < 9; ++j) {
      const double dx = x - (-0.1 + 0.2 * (j % 3));
      const double dy = y - (-0.1 + 0.2 * (j / 3));
      s += w[static_cast<std::size_t>(j)] * std::exp(-(dx * dx + dy * dy) / (2.0 * 0.2 * 0.2));
    }
    return s;
  };
  EXPECT_NEAR(evaluate(*law, w, {0.17, 0.02}).energy, sum(0.17, 0.02) - sum(0.0, 0.0), 1e-14);
  EXPECT_GT(std::abs(sum(0.17, 0.02) - sum(0.0, 0.0)), 0.01);
}

TEST(OgdenLaw, KeepsItsDigitsNearRestAndIsFiniteWhereCollapsed) {
  const auto law = made(law_with("ogden", {70.0, 3.0}));
  // Psi -> mu alpha eps^2 / 2
  EXPECT_NEAR(evaluate(*law, {70.0, 3.0}, {1e-9}).stress[0] / (210.0 * 1e-9), 1.0, 1e-8);
  const LawOutput flat = evaluate(*law, {70.0, -3.0}, {-1.0});
  EXPECT_TRUE(std::isfinite(flat.energy));
  EXPECT_TRUE(std::isfinite(flat.stress[0]));
  EXPECT_TRUE(std::isfinite(flat.tangent[0][0]));
  const LawOutput none = evaluate(*law, {70.0, 0.0}, {0.2});
  EXPECT_EQ(none.energy, 0.0);
  EXPECT_EQ(none.stress[0], 0.0);
}

TEST(SplineLaws, AreLinearInTheirParameters) {
  for (const char* name : {"hermite_stiffness", "bspline_stiffness", "convex_spline"}) {
    const auto law = made(law_with(name, kFive, -0.02, 0.06));
    const LawOutput out = evaluate(*law, kFive, {0.047});
    double sum = 0.0;
    for (int k = 0; k < 5; ++k)
      sum += out.stress_by_parameter[0][k] * kFive[static_cast<std::size_t>(k)];
    ASSERT_GT(out.stress[0], 1.0);
    EXPECT_NEAR(sum, out.stress[0], 1e-12 * out.stress[0]) << name;
  }
}

TEST(Laws, RefuseWhatDoesNotFit) {
  EXPECT_FALSE(make_law(law_with("bilinear", {1.0}), 1));
  EXPECT_FALSE(make_law(law_with("exponential_fibre", {1.0, 1.0}), 2));
  EXPECT_FALSE(make_law(law_with("hermite_stiffness", kFive, 0.1, 0.1), 1));
  EXPECT_FALSE(make_law(law_with("hermite_energy", kFive, 0.1, 0.1), 1));
  EXPECT_FALSE(make_law(law_with("gaussian_energy", kFive, 0.0, 0.1), 2));
  EXPECT_FALSE(make_law(law_with("gaussian_energy_2", kFive, 0.0, 0.1), 2));  // no square
  model::Law unknown;
  unknown.name = "no_such_law";
  EXPECT_FALSE(make_law(unknown, 1));
  model::Law short_of_parameters = law_with("dahl", {1.0, 0.0, 0.0, 0.01});
  short_of_parameters.parameters.pop_back();
  EXPECT_FALSE(make_law(short_of_parameters, 1));
}

TEST(StiffeningLaws, DoNothingWhereTheyShouldNot) {
  const auto stress = [](const char* name, const std::vector<double>& p, double a, double b) {
    const auto law = make_law(law_with(name, p), 2);
    const double strain[] = {a, b};
    LawOutput out{};
    (*law)->evaluate({strain, p.data(), nullptr, 0.0}, out);
    return std::pair{out.stress[0], out.stress[1]};
  };
  EXPECT_EQ(stress("cross_modal", {8000.0}, 0.1, 0.0), std::pair(0.0, 0.0));
  EXPECT_EQ(stress("cross_modal", {8000.0}, 0.0, 0.1), std::pair(0.0, 0.0));
  EXPECT_NEAR(stress("cross_modal", {8000.0}, 0.1, 0.05).first, 8000.0 * 0.1 * 0.0025, 1e-12);
  EXPECT_EQ(stress("strain_limit", {200.0, 0.06}, 0.05, -0.06), std::pair(0.0, 0.0));
  EXPECT_NEAR(stress("strain_limit", {200.0, 0.06}, 0.08, 0.0).first, 4.0, 1e-12);
  EXPECT_NEAR(stress("strain_limit", {200.0, 0.06}, 0.0, -0.08).second, -4.0, 1e-12);
  EXPECT_FALSE(make_law(law_with("cross_modal", {1.0}), 1));
}

TEST(Laws, EveryRowOfTheCatalogueHasOne) {
  ASSERT_GE(model::law_catalogue().size(), 8U);
  for (const model::LawRow& row : model::law_catalogue()) {
    model::Law description;
    description.name = row.name;
    description.range_hi = 0.1;
    description.parameters = model::default_parameters(row, row.grid ? 4 : 5);
    const auto law = make_law(description, row.strains == 0 ? 1 : row.strains);
    ASSERT_TRUE(law) << row.name;
    EXPECT_EQ((*law)->state_count() > 0, row.path_dependent) << row.name;
  }
}

}  // namespace
}  // namespace tenter::mechanics
