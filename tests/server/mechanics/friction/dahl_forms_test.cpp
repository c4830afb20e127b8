// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/friction/dahl_forms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/server/mechanics/differences.h"

namespace tenter::mechanics {
namespace {

using tenter::testing::Comparison;
using tenter::testing::Numbers;

/// Runge-Kutta of order 4 along the way, on slope(strain, stress, sign).
template <class Slope>
double integrate(double e0, double s0, double e1, const Slope& slope) {
  constexpr int kSteps = 4000;
  const double h = (e1 - e0) / kSteps;
  const double sign = h >= 0.0 ? 1.0 : -1.0;
  double s = s0;
  for (int i = 0; i < kSteps; ++i) {
    const double e = e0 + i * h;
    const double k1 = slope(e, s, sign);
    const double k2 = slope(e + 0.5 * h, s + 0.5 * h * k1, sign);
    const double k3 = slope(e + 0.5 * h, s + 0.5 * h * k2, sign);
    const double k4 = slope(e + h, s + h * k3, sign);
    s += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return s;
}

TEST(DahlForms, TheOriginalFormSolvesItsEquationForAnyPower) {
  Numbers numbers(1);
  Comparison stress("original");
  for (const double gamma : {0.5, 1.0, 1.5, 2.0, 3.0}) {
    for (int sample = 0; sample < 20; ++sample) {
      const double sigma_max = numbers.between(0.5, 3.0), alpha = numbers.between(20.0, 120.0);
      const double e0 = numbers.between(-0.05, 0.05), e1 = numbers.between(-0.05, 0.05);
      const double s0 = numbers.between(-0.9, 0.9) * sigma_max;
      // below gamma = 1 the end is reached with a kink: stay before it
      if (gamma < 1.0 && alpha * std::abs(e1 - e0) > 0.8 * sigma_max) continue;
      stress.add(dahl_original(e0, s0, e1, sigma_max, alpha, gamma),
                 integrate(e0, s0, e1, [&](double, double s, double sign) {
                   return alpha * std::pow(std::max(0.0, 1.0 - sign * s / sigma_max), gamma);
                 }));
    }
  }
  stress.judge(1e-8, 0.1);
  // and stays at its maximum, reached on a finite way for a power below one
  EXPECT_EQ(dahl_original(0.0, 0.0, 1.0, 2.0, 50.0, 0.5), 2.0);
  EXPECT_EQ(dahl_original(0.3, 2.0, 0.5, 2.0, 50.0, 1.0), 2.0);
}

TEST(DahlForms, WithPowerOneAndAConstantMaximumAllAreOne) {
  Numbers numbers(2);
  for (int sample = 0; sample < 50; ++sample) {
    const FrictionMaximum maximum{numbers.between(0.3, 3.0), 0.0};
    const double tau = numbers.between(0.004, 0.03);
    const double e0 = numbers.between(-0.05, 0.05), e1 = numbers.between(-0.05, 0.05);
    const double s0 = numbers.between(-1.0, 1.0) * maximum.a;
    const double one = dahl_constant_tau(e0, s0, e1, maximum, tau);
    EXPECT_NEAR(dahl_approximate(e0, s0, e1, maximum, tau), one, 1e-13);
    EXPECT_NEAR(dahl_original(e0, s0, e1, maximum.a, maximum.a / tau, 1.0), one, 1e-13);
    EXPECT_NEAR(dahl_constant_slope(e0, s0, e1, maximum, maximum.a / tau), one, 1e-13);
  }
}

TEST(DahlForms, TheConstantSlopeSolvesItsEquation) {
  Numbers numbers(3);
  Comparison stress("constant slope");
  for (int sample = 0; sample < 60; ++sample) {
    const FrictionMaximum maximum{numbers.between(0.3, 3.0), numbers.between(0.5, 60.0)};
    // one of them where the way back is on the other branch of the solution
    const double alpha = sample % 10 == 0 ? maximum.b : numbers.between(20.0, 150.0);
    const double e0 = numbers.between(0.0, 0.06), e1 = numbers.between(0.0, 0.06);
    const double s0 = numbers.between(-0.9, 0.9) * maximum.a;
    const double sign = sample % 2 == 0 ? 1.0 : -1.0;  // the law is odd
    stress.add(sign * dahl_constant_slope(sign * e0, sign * s0, sign * e1, maximum, alpha),
               integrate(e0, s0, e1, [&](double e, double s, double way) {
                 return alpha * (1.0 - way * s / maximum.at(e));
               }));
  }
  stress.judge(1e-8, 0.1);
  const FrictionMaximum maximum{1.0, 20.0};
  const double there = dahl_constant_slope(-0.03, 0.4, 0.0, maximum, 80.0);
  EXPECT_NEAR(dahl_constant_slope(-0.03, 0.4, 0.05, maximum, 80.0),
              dahl_constant_slope(0.0, there, 0.05, maximum, 80.0), 1e-14);
}

// What 5.3 leaves out: b tau (1 - E), whatever came before.
TEST(DahlForms, TheApproximationIsOffByWhatItLeavesOut) {
  Numbers numbers(4);
  double largest = 0.0;
  for (int sample = 0; sample < 100; ++sample) {
    const FrictionMaximum maximum{numbers.between(0.3, 3.0), numbers.between(0.5, 40.0)};
    const double tau = numbers.between(0.004, 0.03);
    const double e0 = numbers.between(0.0, 0.06), e1 = numbers.between(0.0, 0.06);
    const double s0 = numbers.between(-1.0, 1.0) * maximum.a;
    const double exact = dahl_constant_tau(e0, s0, e1, maximum, tau);
    const double off = dahl_approximate(e0, s0, e1, maximum, tau) - exact;
    const double part = 1.0 - std::exp(-std::abs(e1 - e0) / tau);
    EXPECT_NEAR(off, maximum.b * tau * part, 1e-13);
    largest = std::max(largest, off / maximum.a);
  }
  EXPECT_GT(largest, 0.05);
}

TEST(DahlForms, AllButTheApproximationDoNotSeeHowAWayIsCut) {
  const FrictionMaximum maximum{0.6, 25.0};
  const double e0 = -0.02, s0 = -0.3, between = 0.015, e1 = 0.04;
  const auto off = [&](const auto& form) {
    return std::abs(form(e0, s0, e1) - form(between, form(e0, s0, between), e1));
  };
  EXPECT_LT(
      off([&](double a, double s, double b) { return dahl_constant_tau(a, s, b, maximum, 0.01); }),
      1e-14);
  EXPECT_LT(off([&](double a, double s, double b) {
              return dahl_constant_slope(a, s, b, maximum, 90.0);
            }),
            1e-14);
  EXPECT_LT(
      off([&](double a, double s, double b) { return dahl_original(a, s, b, 0.6, 90.0, 1.7); }),
      1e-14);
}

}  // namespace
}  // namespace tenter::mechanics
