// SPDX-License-Identifier: GPL-3.0-or-later
// Work of friction: stored, lost, and the deformations that stay.
#include "server/mechanics/friction/dahl_work.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "server/mechanics/friction/dahl_tuning.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::mechanics {
namespace {

using tenter::testing::Numbers;

/// a, b, c, tau where friction never gains work up to a strain of 0.1.
std::vector<double> losing(Numbers& numbers) {
  while (true) {
    std::vector<double> p = {numbers.between(0.1, 3.0), numbers.between(0.0, 200.0),
                             numbers.between(0.0, 300.0), numbers.between(0.003, 0.03)};
    if (check_dissipation(p.data(), 0.1).holds) return p;
  }
}

TEST(DahlWork, EveryStepLosesWorkWhereItsParametersAllowIt) {
  Numbers numbers(1);
  double most = 0.0, least = 1.0;
  for (int sample = 0; sample < 200; ++sample) {
    const std::vector<double> p = losing(numbers);
    double stress = 0.0, strain = 0.0;
    for (int step = 0; step < 30; ++step) {
      const double next = numbers.between(-0.08, 0.1);
      const FrictionWork work = friction_work(strain, stress, next, p.data());
      EXPECT_NEAR(work.done, work.stored + work.lost, 1e-14);
      least = std::min(least, work.lost);
      most = std::max(most, work.lost);
      stress = dahl_step(strain, stress, next, p.data()).stress;
      strain = next;
    }
  }
  EXPECT_GT(most, 1e-2);
  EXPECT_GT(least, -1e-15);
}

// D of the header along the way, by Simpson's rule on short steps.
TEST(DahlWork, WhatIsLostIsTheIntegralOfTheDissipation) {
  const double p[] = {0.5, 20.0, 50.0, 0.012};
  for (const auto& [e0, s0, e1] :
       {std::tuple{0.0, 0.0, 0.05}, std::tuple{0.05, 1.2, 0.01}, std::tuple{0.02, -0.4, 0.06}}) {
    constexpr int kSteps = 2000;
    const double h = (e1 - e0) / kSteps, s = h > 0.0 ? 1.0 : -1.0;
    double sum = 0.0;
    for (int i = 0; i <= kSteps; ++i) {
      const double e = e0 + i * h;
      const double stress = dahl_step(e0, s0, e, p).stress;
      const double maximum = p[0] + p[1] * e + p[2] * e * e, slope = p[1] + 2.0 * p[2] * e;
      const double weight = i == 0 || i == kSteps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
      sum += weight * std::abs(h) / 3.0 * stress * stress / maximum *
             (1.0 + s * p[3] * slope / (2.0 * maximum));
    }
    const double lost = friction_work(e0, s0, e1, p).lost;
    ASSERT_GT(lost, 1e-3);
    EXPECT_NEAR(lost, sum, 1e-9 * lost);
  }
}

// The area is summed up from stresses alone: trapezoids, extrapolated to no step.
TEST(DahlWork, ASteadyCycleLosesTheAreaOfItsLoop) {
  const double p[] = {0.5, 30.0, 0.0, 0.008};
  const double low = 0.01, high = 0.06;
  double stress = 0.0, strain = 0.0;
  const auto go = [&](double to) {
    const FrictionWork work = friction_work(strain, stress, to, p);
    stress = dahl_step(strain, stress, to, p).stress;
    strain = to;
    return work;
  };
  for (int cycle = 0; cycle < 20; ++cycle) {
    go(high);
    go(low);
  }
  const double start = stress;
  const auto area = [&](int steps) {
    double sum = 0.0, s = start, e = low;
    for (const double to : {high, low}) {
      const double from = e;
      for (int i = 1; i <= steps; ++i) {
        const double next = from + (to - from) * i / steps;
        const double after = dahl_step(e, s, next, p).stress;
        sum += 0.5 * (s + after) * (next - e);
        s = after;
        e = next;
      }
    }
    return sum;
  };
  const double coarse = area(1000), fine = area(2000), finest = area(4000);
  const double better = (4.0 * fine - coarse) / 3.0, best = (4.0 * finest - fine) / 3.0;
  const FrictionWork there = go(high), back = go(low);
  EXPECT_NEAR(stress, start, 1e-12);  // the loop is closed
  ASSERT_GT(best, 1e-2);
  EXPECT_NEAR(there.done + back.done, (16.0 * best - better) / 15.0, 1e-8 * best);
  EXPECT_NEAR(there.lost + back.lost, there.done + back.done, 1e-12);
  EXPECT_GT(there.lost, 0.0);
  EXPECT_GT(back.lost, 0.0);
}

TEST(DahlWork, TheCheckFindsWhereWorkIsGained) {
  // b tau > 2 a: near rest, and not farther out
  const double growing[] = {1.0, 300.0, 0.0, 0.02};
  const DissipationCheck near_rest = check_dissipation(growing, 1.0);
  EXPECT_FALSE(near_rest.holds);
  EXPECT_EQ(near_rest.fails_from, 0.0);
  EXPECT_NEAR(near_rest.fails_to, (300.0 * 0.02 - 2.0) / 600.0, 1e-15);
  EXPECT_NEAR(near_rest.worst, 3.0, 1e-12);
  // a saturated step back, there: what it stored is more than what it took
  const double e = 0.5 * near_rest.fails_to;
  const double saturated = -(1.0 + 300.0 * e + 300.0 * 0.02);
  EXPECT_LT(friction_work(e, saturated, 0.9 * e, growing).lost, 0.0);
  const double out = 2.0 * near_rest.fails_to;
  const double outside = -(1.0 + 300.0 * out + 300.0 * 0.02);
  EXPECT_GT(friction_work(out, outside, 0.9 * out, growing).lost, 0.0);
  const double allowed[] = {1.0, largest_growth(1.0, 0.02), 0.0, 0.02};
  EXPECT_TRUE(check_dissipation(allowed, 1.0).holds);

  // a curved maximum may fail between two strains only
  const double curved[] = {0.002, 0.0, 100.0, 0.02};
  const DissipationCheck between = check_dissipation(curved, 1.0);
  ASSERT_FALSE(between.holds);
  EXPECT_GT(between.fails_from, 0.0);
  EXPECT_GT(between.fails_to, between.worst_strain);
  for (const double edge : {between.fails_from, between.fails_to})
    EXPECT_NEAR(0.02 * 200.0 * edge, 2.0 * (0.002 + 100.0 * edge * edge), 1e-12);
}

TEST(DahlTuning, AMaterialKeepsTheDeformationThatWasAskedFor) {
  for (const double growth : {0.0, 8.0}) {
    const FrictionWish wish{135.6, 0.016, 0.05, growth, 0.95};
    const auto tuned = tune_friction(wish);
    ASSERT_TRUE(tuned) << tuned.error().message;
    EXPECT_NEAR(persistent_strain(wish.stiffness, *tuned), wish.persistent, 1e-12);
    if (growth == 0.0) {
      EXPECT_NEAR(tuned->a, wish.stiffness * wish.persistent, 1e-12);  // the thesis' own
      EXPECT_NEAR(tuned->a / tuned->tau,
                  tuned->a / (wish.saturation - wish.persistent) * std::log(2.0 / 0.05), 1e-9);
    }
    // loaded far and let go: the strain without load, by bisection on the law itself
    const double p[] = {tuned->a, tuned->b, 0.0, tuned->tau};
    const auto rest_after = [&](double loaded) {
      const double there = dahl_step(0.0, 0.0, loaded, p).stress;
      double low = 0.0, high = loaded;
      for (int i = 0; i < 100; ++i) {
        const double middle = 0.5 * (low + high);
        const double force = wish.stiffness * middle + dahl_step(loaded, there, middle, p).stress;
        (force > 0.0 ? high : low) = middle;
      }
      return 0.5 * (low + high);
    };
    EXPECT_NEAR(rest_after(1.0), wish.persistent, 1e-9);
    // from the saturation deformation about c of it stays, from half of that less
    EXPECT_GT(rest_after(wish.saturation), 0.9 * wish.persistent);
    EXPECT_LT(rest_after(0.5 * wish.saturation), 0.8 * wish.persistent);
  }
  const auto too_much = tune_friction({135.6, 0.016, 0.05, 120.0, 0.95});
  ASSERT_FALSE(too_much);
  EXPECT_NE(too_much.error().message.find("gain work"), std::string::npos);
  EXPECT_FALSE(tune_friction({135.6, 0.05, 0.04, 0.0, 0.95}));
  EXPECT_FALSE(tune_friction({135.6, 0.02, 0.04, 0.0, 1.0}));
}

}  // namespace
}  // namespace tenter::mechanics
