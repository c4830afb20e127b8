// SPDX-License-Identifier: GPL-3.0-or-later
// Laws that remember: Maxwell, Kelvin-Voigt, plastic set, softening.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "server/mechanics/law.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/law_checks.h"

namespace tenter::mechanics {
namespace {

using testing::check_law;
using testing::Comparison;
using testing::difference;
using testing::follow_law;
using testing::law_with;
using testing::Numbers;

std::vector<double> ramp(double from, double to, int steps) {
  std::vector<double> strains;
  for (int i = 1; i <= steps; ++i) strains.push_back(from + (to - from) * i / steps);
  return strains;
}

std::vector<double> follow(const model::Law& description, const std::vector<double>& strains,
                           double step_s = 1.0) {
  const auto law = make_law(description, 1);
  EXPECT_TRUE(law) << description.name;
  return follow_law(**law, testing::values_of(description), strains, step_s);
}

TEST(MemoryLaws, HoldTheDerivativesOfALaw) {
  check_law({.words = "maxwell", .law = law_with("maxwell", {80.0, 0.7})});
  check_law({.words = "maxwell on two", .law = law_with("maxwell", {80.0, 0.7}), .strains = 2});
  check_law({.words = "maxwell, short steps", .law = law_with("maxwell", {80.0, 1e5})});
  check_law({.words = "kelvin-voigt", .law = law_with("kelvin_voigt", {15.0})});
  check_law(
      {.words = "kelvin-voigt on two", .law = law_with("kelvin_voigt", {15.0}), .strains = 2});
}

// A random path soon has no new maxima: these are checked on paths whose range grows, at several
// seeds.
TEST(MemoryLaws, OfTheMaximumHoldThemOnGrowingPaths) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    check_law({.words = "plastic set",
               .law = law_with("plastic_set", {60.0, 0.02}),
               .kinks = {0.02},
               .seed = seed});
    for (const double power : {1.0, 2.5})
      check_law({.words = "softening",
                 .law = law_with("softening", {60.0, 0.03, power}),
                 .lo = 0.0,
                 .seed = seed});
  }
}

TEST(MaxwellLaw, RelaxesAsItsClosedForm) {
  const model::Law law = law_with("maxwell", {80.0, 5.0});
  std::vector<double> strains = {0.05};
  strains.resize(41, 0.05);
  // the first step is instantaneous, then a hold
  const auto made = *make_law(law, 1);
  const std::vector<double> jump = follow_law(*made, {80.0, 5.0}, {0.05}, 0.0);
  EXPECT_NEAR(jump[0], 4.0, 1e-12);
  // a ramp of one second, then the hold: sigma = k e T/t (1 - E) exp(-t/T)
  const std::vector<double> held = follow(law, strains, 1.0);
  const double peak = 80.0 * 0.05 * 5.0 * (1.0 - std::exp(-0.2));
  for (std::size_t i = 0; i < held.size(); ++i)
    EXPECT_NEAR(held[i], peak * std::exp(-0.2 * static_cast<double>(i)), 1e-12);
}

TEST(MaxwellLaw, DoesNotSeeHowARampIsCut) {
  const model::Law law = law_with("maxwell", {80.0, 5.0});
  const double coarse = follow(law, ramp(0.0, 0.06, 1), 12.0).back();
  const double fine = follow(law, ramp(0.0, 0.06, 240), 0.05).back();
  ASSERT_GT(coarse, 0.5);
  EXPECT_NEAR(fine, coarse, 1e-12);
}

TEST(MaxwellLaw, IsASpringWhenFastAndADashpotWhenSlow) {
  const model::Law law = law_with("maxwell", {80.0, 5.0});
  EXPECT_NEAR(follow(law, ramp(0.0, 0.06, 10), 1e-6).back(), 4.8, 1e-4);
  // slow: k T times the strain rate
  EXPECT_NEAR(follow(law, ramp(0.0, 0.06, 100), 100.0).back(), 80.0 * 5.0 * 0.06 / 1e4, 1e-7);
}

TEST(KelvinVoigtLaw, IsViscosityTimesRate) {
  const model::Law law = law_with("kelvin_voigt", {15.0});
  const std::vector<double> pulled = follow(law, {0.01, 0.02, 0.02, 0.01}, 0.5);
  EXPECT_NEAR(pulled[0], 0.3, 1e-12);
  EXPECT_NEAR(pulled[1], 0.3, 1e-12);
  EXPECT_EQ(pulled[2], 0.0);
  EXPECT_NEAR(pulled[3], -0.3, 1e-12);
  // no rate where no time passes
  EXPECT_EQ(follow(law, {0.01}, 0.0)[0], 0.0);
}

std::vector<double> two_cycles_and_a_larger_one() {
  std::vector<double> strains = ramp(0.0, 0.05, 10);
  for (const double end : {0.0, 0.05, 0.0, 0.08, 0.0}) {
    const std::vector<double> more = ramp(strains.back(), end, 10);
    strains.insert(strains.end(), more.begin(), more.end());
  }
  return strains;
}

TEST(PlasticSetLaw, ChangesWithNewMaximaOnly) {
  const std::vector<double> strains = two_cycles_and_a_larger_one();
  const std::vector<double> stress = follow(law_with("plastic_set", {60.0, 0.02}), strains);
  EXPECT_EQ(stress[2], 0.0);  // below yield
  EXPECT_NEAR(stress[9], -60.0 * 0.03, 1e-12);
  for (std::size_t i = 10; i < 40; ++i) EXPECT_EQ(stress[i], stress[9]) << i;
  EXPECT_NEAR(stress[49], -60.0 * 0.06, 1e-12);
  EXPECT_EQ(stress[59], stress[49]);
}

LawOutput answer(const Law& law, double first, double second, const std::vector<double>& p,
                 double largest) {
  const double strain[2] = {first, second};
  LawOutput out{};
  law.evaluate({strain, p.data(), &largest, 1.0}, out);
  return out;
}

// No potential of the step, so not for the shared checks: against the law of one strain, and
// differences.
TEST(CoupledPlasticSetLaw, IsPlasticSetWithAShareInTheSecondStress) {
  const auto coupled = *make_law(law_with("plastic_set_coupled", {60.0, 25.0, 0.02}), 2);
  const auto single = *make_law(law_with("plastic_set", {60.0, 0.02}), 1);
  const std::vector<double> p = {60.0, 25.0, 0.02};
  Comparison by_strain("stress by strain"), by_state("stress by state"),
      by_p("stress by parameter");
  Numbers numbers(3);
  for (int k = 0; k < 200; ++k) {
    const double first = numbers.between(0.0, 0.1);
    const double second = numbers.between(-0.05, 0.05);
    const double largest = numbers.between(0.0, 0.1);
    if (std::abs(first - largest) < 1e-3 || std::abs(std::max(first, largest) - 0.02) < 1e-3)
      continue;
    const LawOutput out = answer(*coupled, first, second, p, largest);
    EXPECT_EQ(out.stress[0], answer(*single, first, 0.0, {60.0, 0.02}, largest).stress[0]);
    EXPECT_NEAR(out.stress[1], out.stress[0] * 25.0 / 60.0, 1e-12);
    EXPECT_EQ(out.state[0], std::max(first, largest));
    for (int i = 0; i < 2; ++i) {
      by_strain.add(
          out.tangent[i][0],
          difference([&](double e) { return answer(*coupled, e, second, p, largest).stress[i]; },
                     first, 1e-5));
      EXPECT_EQ(out.tangent[i][1], 0.0);
      by_state.add(
          out.stress_by_state[i][0],
          difference([&](double m) { return answer(*coupled, first, second, p, m).stress[i]; },
                     largest, 1e-5));
      for (std::size_t j = 0; j < p.size(); ++j)
        by_p.add(out.stress_by_parameter[i][j],
                 difference(
                     [&](double x) {
                       std::vector<double> moved = p;
                       moved[j] = x;
                       return answer(*coupled, first, second, moved, largest).stress[i];
                     },
                     p[j], 1e-5));
    }
  }
  by_strain.judge(1e-6, 1.0);
  by_state.judge(1e-6, 1.0);
  by_p.judge(1e-6, 1e-3);
}

TEST(SofteningLaw, LeavesACompressedDirectionAlone) {
  const auto law = *make_law(law_with("softening", {60.0, 0.004, 1.5}), 1);
  const LawOutput pressed = answer(*law, -0.02, 0.0, {60.0, 0.004, 1.5}, 0.05);
  EXPECT_EQ(pressed.stress[0], 0.0);
  EXPECT_EQ(pressed.tangent[0][0], 0.0);
  EXPECT_EQ(pressed.state[0], 0.05);
  EXPECT_LT(answer(*law, 0.02, 0.0, {60.0, 0.004, 1.5}, 0.05).stress[0], -0.1);
}

TEST(SofteningLaw, TakesFromLaterLoadingsOnly) {
  const std::vector<double> strains = two_cycles_and_a_larger_one();
  const std::vector<double> stress = follow(law_with("softening", {60.0, 0.004, 1.0}), strains);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(stress[i], 0.0, 1e-12) << i;
  // the unloading after it, and the second and third pull, alike
  for (std::size_t i = 20; i < 30; ++i) {
    const double e = strains[i];
    EXPECT_NEAR(stress[i], -60.0 * e * (1.0 - std::exp(-(0.05 - e) / 0.004)), 1e-12) << i;
  }
  EXPECT_LT(stress[24], -1.0);
  EXPECT_NEAR(stress[14], stress[24], 1e-12);
  EXPECT_NEAR(stress[49], 0.0, 1e-12);  // beyond the old maximum
}

}  // namespace
}  // namespace tenter::mechanics
