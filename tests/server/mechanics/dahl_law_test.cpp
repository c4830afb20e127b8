// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/dahl.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/law_checks.h"

namespace tenter::mechanics {
namespace {

using testing::check_law;
using testing::follow_law;
using testing::law_with;
using testing::Numbers;

// a, b, c, tau
const double kConstant[] = {2.0, 0.0, 0.0, 0.01};
const double kGrowing[] = {0.5, 30.0, 0.0, 0.008};
const double kCurved[] = {0.5, 20.0, 150.0, 0.012};

/// Runge-Kutta of order 4 on equation 5.2 itself; `potential` gathers the integral of the stress.
double integrate(double e0, double s0, double e1, const double* p, double& potential) {
  constexpr int kSteps = 4000;
  const double h = (e1 - e0) / kSteps;
  const double sign = h >= 0.0 ? 1.0 : -1.0;
  const auto slope = [&](double e, double s) {
    return (p[0] + p[1] * std::abs(e) + p[2] * e * e - sign * s) / p[3];
  };
  double s = s0;
  potential = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double e = e0 + i * h;
    const double k1 = slope(e, s);
    const double k2 = slope(e + 0.5 * h, s + 0.5 * h * k1);
    const double k3 = slope(e + 0.5 * h, s + 0.5 * h * k2);
    const double k4 = slope(e + h, s + h * k3);
    const double next = s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    potential += 0.5 * h * (s + next);
    s = next;
  }
  return s;
}

TEST(DahlLaw, HoldsTheDerivativesOfALaw) {
  for (const double* p : {kConstant, kGrowing, kCurved}) {
    const std::vector<double> values(p, p + 4);
    check_law({.words = "dahl b " + std::to_string(p[1]), .law = law_with("dahl", values)});
    check_law({.words = "dahl on two", .law = law_with("dahl", values), .strains = 2});
  }
}

TEST(LinearisedDahlLaw, HoldsTheDerivativesOfALaw) {
  for (const double* p : {kConstant, kGrowing, kCurved}) {
    const std::vector<double> values(p, p + 4);
    check_law({.words = "dahl_linearised b " + std::to_string(p[1]),
               .law = law_with("dahl_linearised", values),
               .kinks = {0.0}});
  }
}

/// Steps of one length through a pull and a release: the shorter they are, the nearer to 5.2, but
/// for one step after the reversal.
TEST(LinearisedDahlLaw, ComesToTheExactOneWithShorterSteps) {
  const std::vector<double> values(kGrowing, kGrowing + 4);
  const auto exact = make_law(law_with("dahl", values), 1).value();
  const auto linear = make_law(law_with("dahl_linearised", values), 1).value();
  double off[2];
  for (int fine = 0; fine < 2; ++fine) {
    const int steps = fine ? 80 : 40;
    std::vector<double> path;
    for (int k = 1; k <= steps; ++k) path.push_back(0.04 * k / steps);
    for (int k = 1; k <= steps; ++k) path.push_back(0.04 - 0.03 * k / steps);
    const auto wanted = follow_law(*exact, values, path, 1.0);
    const auto found = follow_law(*linear, values, path, 1.0);
    off[fine] = 0.0;
    for (std::size_t k = 2; k < path.size(); ++k) {
      const bool is_reversal = k == static_cast<std::size_t>(steps);
      if (!is_reversal) off[fine] = std::max(off[fine], std::abs(found[k] - wanted[k]));
      if (is_reversal) {
        EXPECT_GT(std::abs(found[k] - wanted[k]), 2.0 * off[fine]);
      }
    }
    ASSERT_GT(off[fine], 1e-6);
  }
  EXPECT_LT(off[1], 0.4 * off[0]);
}

TEST(DahlLaw, SolvesItsDifferentialEquation) {
  Numbers numbers(1);
  for (const double* p : {kConstant, kGrowing, kCurved}) {
    for (int sample = 0; sample < 40; ++sample) {
      const double e0 = numbers.between(-0.05, 0.08);
      const double e1 = numbers.between(-0.05, 0.08);
      const double s0 = numbers.between(-1.0, 1.0);
      double potential = 0.0;
      const double stress = integrate(e0, s0, e1, p, potential);
      const DahlStep step = dahl_step(e0, s0, e1, p);
      EXPECT_NEAR(step.stress, stress, 2e-6);
      EXPECT_NEAR(step.potential, potential, 2e-7);
    }
  }
}

TEST(DahlLaw, DoesNotSeeHowAStepIsCut) {
  Numbers numbers(2);
  for (int sample = 0; sample < 100; ++sample) {
    const double e0 = numbers.between(-0.05, 0.08);
    const double e1 = numbers.between(-0.05, 0.08);
    const double between = e0 + numbers.between(0.0, 1.0) * (e1 - e0);
    const double s0 = numbers.between(-1.0, 1.0);
    const DahlStep whole = dahl_step(e0, s0, e1, kCurved);
    const DahlStep first = dahl_step(e0, s0, between, kCurved);
    const DahlStep second = dahl_step(between, first.stress, e1, kCurved);
    EXPECT_NEAR(second.stress, whole.stress, 1e-12);
    EXPECT_NEAR(first.potential + second.potential, whole.potential, 1e-13);
  }
}

TEST(DahlLaw, SaturatesAtItsMaximum) {
  EXPECT_NEAR(dahl_step(0.0, 0.0, 0.2, kConstant).stress, 2.0, 1e-7);
  EXPECT_NEAR(dahl_step(0.2, 2.0, 0.0, kConstant).stress, -2.0, 1e-7);
  // pre-sliding: d sigma/d eps = a / tau at the start
  EXPECT_NEAR(dahl_step(0.0, 0.0, 1e-7, kConstant).stress / 1e-7, 200.0, 1e-2);
}

TEST(DahlLaw, ClosesARepeatedCycle) {
  const auto law = *make_law(law_with("dahl", {0.5, 30.0, 0.0, 0.008}), 1);
  std::vector<double> strains;
  for (int cycle = 0; cycle < 12; ++cycle) {
    for (int i = 1; i <= 20; ++i) strains.push_back(0.004 * i);
    for (int i = 19; i >= 0; --i) strains.push_back(0.004 * i);
  }
  const std::vector<double> stresses = follow_law(*law, {0.5, 30.0, 0.0, 0.008}, strains, 1.0);
  const std::size_t turn = 40;
  for (std::size_t i = 0; i < turn; ++i)
    EXPECT_NEAR(stresses[stresses.size() - 1 - i], stresses[stresses.size() - 1 - i - turn], 1e-9);
  // and the loop is open: loading and unloading differ
  EXPECT_GT(stresses[stresses.size() - 30] - stresses[stresses.size() - 12], 0.5);
}

TEST(DahlLaw, DissipatesOverEveryClosedCycle) {
  Numbers numbers(3);
  for (int sample = 0; sample < 40; ++sample) {
    const double a = numbers.between(0.1, 3.0);
    const double tau = numbers.between(0.003, 0.03);
    const double b = numbers.between(0.0, 1.0) * 2.0 * a / tau;  // b tau <= 2 sigma_max
    const double p[] = {a, b, 0.0, tau};
    // a random closed path, gone round until it repeats itself; then the work of one more round
    std::vector<double> round = {0.0};
    for (int i = 0; i < 6; ++i) round.push_back(numbers.between(-0.05, 0.08));
    double stress = 0.0;
    double last = 0.0;
    double work = 0.0;
    for (int turn = 0; turn < 40; ++turn) {
      work = 0.0;
      for (const double strain : round) {
        const DahlStep step = dahl_step(last, stress, strain, p);
        work += step.potential;
        stress = step.stress;
        last = strain;
      }
    }
    EXPECT_GT(work, 0.0) << "a " << a << " b " << b << " tau " << tau;
  }
}

TEST(DahlLaw, IsOddUnderReversalOfTheStrain) {
  Numbers numbers(4);
  for (int sample = 0; sample < 50; ++sample) {
    const double e0 = numbers.between(-0.05, 0.08);
    const double e1 = numbers.between(-0.05, 0.08);
    const double s0 = numbers.between(-1.0, 1.0);
    EXPECT_NEAR(dahl_step(-e0, -s0, -e1, kCurved).stress, -dahl_step(e0, s0, e1, kCurved).stress,
                1e-13);
  }
}

TEST(DahlLaw, DoesNotKnowTime) {
  const auto law = *make_law(law_with("dahl", {2.0, 0.0, 0.0, 0.01}), 1);
  const std::vector<double> strains = {0.01, 0.03, 0.02, 0.02, 0.05};
  const auto fast = follow_law(*law, {2.0, 0.0, 0.0, 0.01}, strains, 0.001);
  const auto slow = follow_law(*law, {2.0, 0.0, 0.0, 0.01}, strains, 1000.0);
  EXPECT_EQ(fast, slow);
  EXPECT_NEAR(fast[2], fast[3], 1e-14);  // nothing decays in a hold
}

}  // namespace
}  // namespace tenter::mechanics
