// SPDX-License-Identifier: GPL-3.0-or-later
// What hides in a fabric: its derivatives, and the same as the differential laws in small steps.
#include "tests/twin/fabrics/laws/hidden_laws.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "tests/twin/cloth.h"
#include "tests/twin/random.h"

namespace tenter::twin {
namespace {

constexpr double kStiffness = 60.0;
const Eigen::Vector2d kBoth(kStiffness, 0.8 * kStiffness);

/// A loop, a larger one with a hold, and past zero: strain of u, duration.
struct Leg {
  double strain, seconds;
};
const std::vector<Leg> kPath = {{0.03, 3.0}, {0.01, 2.0}, {0.06, 30.0}, {0.06, 20.0},
                                {0.02, 3.0}, {0.04, 1.0}, {-0.01, 4.0}};

/// Each law alone, and the twin cloth's knob for the same.
struct Case {
  const char* name;
  std::function<void(HiddenLaws&)> hide;
  std::function<void(Cloth&)> knob;
  double tolerance = 2e-3;  ///< of the largest stress that it adds, for steps of 1/400 of a leg
};
std::vector<Case> cases() {
  return {{"friction", [](HiddenLaws& l) { l.friction_N_m[0] = 0.4; },
           [](Cloth& c) {
             c.friction = {{0.0, 0.4, 0.0, 0.01}};
           }},
          {"growing friction",
           [](HiddenLaws& l) {
             l.friction_N_m[0] = 0.1;
             l.friction_growth_N_m[0] = 6.0;
           },
           [](Cloth& c) {
             c.friction = {{0.0, 0.1, 6.0, 0.01}};
           }},
          {"maxwell", [](HiddenLaws& l) { l.maxwell_N_m[0] = 20.0; },
           [](Cloth& c) { c.maxwell[0] = 20.0; }},
          {"kelvin", [](HiddenLaws& l) { l.kelvin_voigt_N_s_m[0] = 20.0; },
           [](Cloth& c) { c.kelvin_voigt[0] = 20.0; }},
          {"plastic", [](HiddenLaws& l) { l.plastic_share[0] = 0.3; },
           [](Cloth& c) { c.plastic_share[0] = 0.3; }},
          {"softening", [](HiddenLaws& l) { l.softening[0] = 0.3; },
           [](Cloth& c) { c.softening[0] = 0.3; }},
          {"cubic", [](HiddenLaws& l) { l.cubic_N_m[0] = 3000.0; },
           [](Cloth& c) { c.cubic[0] = 3000.0; }}};
}

/// Second Piola stress of u at the end of each leg, by steps of the twin cloth.
std::vector<double> by_small_steps(Cloth cloth) {
  constexpr int kSteps = 400;
  cloth.elastic = {kStiffness, kBoth[1], 0.0, 20.0};
  ClothState state;
  std::vector<double> stresses;
  double from = 0.0;
  for (const Leg& leg : kPath) {
    double nominal = 0.0, stretch = 1.0;
    for (int k = 1; k <= kSteps; ++k) {
      stretch = std::sqrt(1.0 + 2.0 * (from + (leg.strain - from) * k / kSteps));
      nominal = step(cloth, 0.0, {stretch, 1.0, 0.0}, leg.seconds / kSteps, state).x;
    }
    stresses.push_back(nominal / stretch);
    from = leg.strain;
  }
  return stresses;
}

TEST(HiddenLaws, AreTheDifferentialLawsOfTheTwinCloth) {
  for (const Case& c : cases()) {
    HiddenLaws laws;
    c.hide(laws);
    Cloth cloth;
    c.knob(cloth);
    const std::vector<double> expected = by_small_steps(cloth), plain = by_small_steps(Cloth());
    double largest = 0.0;
    for (std::size_t i = 0; i < plain.size(); ++i)
      largest = std::max(largest, std::abs(expected[i] - plain[i]));
    ASSERT_GT(largest, 0.05) << c.name;
    LawHistory history;
    Eigen::Vector3d from = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < kPath.size(); ++i) {
      const Eigen::Vector3d to(kPath[i].strain, 0.0, 0.0);
      // the first loading's knots: plastic and softening are laws of the largest strain so far
      const LawValue value = hidden_at(laws, history, from, to, kBoth, kPath[i].seconds);
      EXPECT_NEAR(value.stress[0], expected[i] - plain[i], c.tolerance * largest)
          << c.name << " leg " << i;
      history = advance(laws, history, from, to, kPath[i].seconds);
      from = to;
    }
  }
}

TEST(HiddenLaws, StressIsTheSlopeOfTheEnergyAndTangentOfTheStress) {
  HiddenLaws laws;
  laws.coupling_N_m = 12.0;
  laws.cross_stretch_N_m = 900.0;
  laws.cross_shear_N_m = 700.0;
  laws.cubic_N_m = {3000.0, 2000.0, 100.0};
  laws.friction_N_m = {0.4, 0.3, 0.1};
  laws.friction_growth_N_m = {3.0, 2.0, 1.0};
  laws.maxwell_N_m = {20.0, 10.0};
  laws.kelvin_voigt_N_s_m = {5.0, 3.0};
  laws.plastic_share = {0.2, 0.1};
  laws.softening = {0.2, 0.3};
  laws.expansion = 0.01;
  Random random(stream_seed(5, "laws"));
  LawHistory history;
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  for (int trial = 0; trial < 30; ++trial) {
    const Eigen::Vector3d to(random.uniform(-0.01, 0.06), random.uniform(-0.01, 0.06),
                             random.uniform(-0.1, 0.1));
    // friction has a kink where it turns: no difference may reach over it
    if ((to - from).cwiseAbs().minCoeff() < 1e-5) continue;
    const auto at = [&](const Eigen::Vector3d& e) {
      return hidden_at(laws, history, from, e, kBoth, 0.7);
    };
    const LawValue value = at(to);
    ASSERT_GT(value.stress.norm(), 0.01);
    constexpr double kStep = 1e-6;
    for (int m = 0; m < 3; ++m) {
      const Eigen::Vector3d by = kStep * Eigen::Vector3d::Unit(m);
      const LawValue up = at(to + by), down = at(to - by);
      EXPECT_NEAR((up.energy - down.energy) / (2.0 * kStep), value.stress[m], 1e-6) << trial;
      const Eigen::Vector3d tangent = (up.stress - down.stress) / (2.0 * kStep);
      EXPECT_LT((tangent - value.tangent.col(m)).norm(), 1e-4 * (1.0 + tangent.norm())) << trial;
    }
    history = advance(laws, history, from, to, 0.7);
    from = to;
  }
}

TEST(HiddenLaws, APatchIsStiffestInItsMiddle) {
  HiddenLaws laws;
  laws.patch_share = 0.5;
  laws.patch_m = {0.03, 0.04};
  EXPECT_DOUBLE_EQ(laws.stiffer_at({0.03, 0.04}), 1.5);
  EXPECT_NEAR(laws.stiffer_at({0.05, 0.04}), 1.0 + 0.5 * std::exp(-1.0), 1e-12);
  EXPECT_DOUBLE_EQ(HiddenLaws().stiffer_at({0.03, 0.04}), 1.0);
}

}  // namespace
}  // namespace tenter::twin
