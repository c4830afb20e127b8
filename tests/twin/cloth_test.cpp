// SPDX-License-Identifier: GPL-3.0-or-later
// The generator's cloth against closed forms, where they exist.
#include "tests/twin/cloth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tenter::twin {
namespace {

/// Pulls x from one engineering strain to another in `count` steps.
Nominal pull(const Cloth& cloth, ClothState& state, double from, double to, int count,
             double rate = 0.01) {
  Nominal stress;
  const double dt = std::abs(to - from) / rate / count;
  for (int k = 1; k <= count; ++k)
    stress = step(cloth, 0.0, {1.0 + from + (to - from) * k / count, 1.0, 0.0}, dt, state);
  return stress;
}

double green(double strain) {
  return strain + 0.5 * strain * strain;
}

TEST(TwinCloth, PlainClothIsStVenantKirchhoff) {
  Cloth cloth;
  ClothState state;
  const double x = 1.05, y = 0.98, g = 0.07;
  const Nominal p = step(cloth, 0.0, {x, y, g}, 0.0, state);
  const double eu = 0.5 * (x * x - 1.0), ev = 0.5 * (g * g + y * y - 1.0), euv = 0.5 * x * g;
  const double su = 600.0 * eu + 150.0 * ev, sv = 800.0 * ev + 150.0 * eu, suv = 200.0 * euv;
  EXPECT_NEAR(p.x, x * su + g * suv, 1e-11);
  EXPECT_NEAR(p.y, y * sv, 1e-11);
  EXPECT_NEAR(p.shear, x * suv + g * sv, 1e-11);
}

// in rotated axes too, the nominal stress is the derivative of the energy
TEST(TwinCloth, StressIsDerivativeOfEnergyAtAnAngle) {
  const Cloth cloth;
  const double angle = 0.6;
  const auto energy = [&](const Deformation& f) {
    const double c = std::cos(angle), s = std::sin(angle);
    const double exx = 0.5 * (f.x * f.x - 1), eyy = 0.5 * (f.shear * f.shear + f.y * f.y - 1),
                 exy = 0.5 * f.x * f.shear;
    // along weft: the test's direction at -angle
    const double eu = c * c * exx + s * s * eyy - 2 * c * s * exy;
    const double ev = s * s * exx + c * c * eyy + 2 * c * s * exy;
    const double euv = c * s * (exx - eyy) + (c * c - s * s) * exy;
    return 300.0 * eu * eu + 400.0 * ev * ev + 150.0 * eu * ev + 50.0 * 4.0 * euv * euv;
  };
  const Deformation f{1.06, 0.97, 0.05};
  ClothState state;
  const Nominal p = step(cloth, angle, f, 0.0, state);
  const double h = 1e-6;
  EXPECT_NEAR(p.x, (energy({f.x + h, f.y, f.shear}) - energy({f.x - h, f.y, f.shear})) / (2 * h),
              1e-6);
  EXPECT_NEAR(p.y, (energy({f.x, f.y + h, f.shear}) - energy({f.x, f.y - h, f.shear})) / (2 * h),
              1e-6);
  EXPECT_NEAR(p.shear,
              (energy({f.x, f.y, f.shear + h}) - energy({f.x, f.y, f.shear - h})) / (2 * h), 1e-6);
}

// in rotated axes: the nominal stress is the derivative of the energy
TEST(TwinCloth, CrossModalStiffeningHasAnEnergy) {
  Cloth cloth;
  cloth.elastic = {0.0, 0.0, 0.0, 0.0};
  cloth.cross_stretch = 2e4;
  cloth.cross_shear = 3e4;
  const double angle = 0.6;
  const auto energy = [&](const Deformation& f) {
    const double c = std::cos(angle), s = std::sin(angle);
    const double exx = 0.5 * (f.x * f.x - 1), eyy = 0.5 * (f.shear * f.shear + f.y * f.y - 1),
                 exy = 0.5 * f.x * f.shear;
    const double eu = c * c * exx + s * s * eyy - 2 * c * s * exy;
    const double ev = s * s * exx + c * c * eyy + 2 * c * s * exy;
    const double g = 2.0 * (c * s * (exx - eyy) + (c * c - s * s) * exy);
    return 1e4 * eu * eu * ev * ev + 1.5e4 * (eu * eu + ev * ev) * g * g;
  };
  const Deformation f{1.12, 1.07, 0.05};
  ClothState state;
  const Nominal p = step(cloth, angle, f, 0.0, state);
  const double h = 1e-6;
  EXPECT_GT(p.x, 10.0);
  EXPECT_NEAR(p.x, (energy({f.x + h, f.y, f.shear}) - energy({f.x - h, f.y, f.shear})) / (2 * h),
              1e-6);
  EXPECT_NEAR(p.y, (energy({f.x, f.y + h, f.shear}) - energy({f.x, f.y - h, f.shear})) / (2 * h),
              1e-6);
  EXPECT_NEAR(p.shear,
              (energy({f.x, f.y, f.shear + h}) - energy({f.x, f.y, f.shear - h})) / (2 * h), 1e-6);
  // with one mode alone, nothing
  EXPECT_EQ(step(cloth, 0.0, {1.1, 1.0, 0.0}, 0.0, state).x, 0.0);
}

TEST(TwinCloth, DahlFrictionSaturatesAndReversesAsItsSolutionSays) {
  Cloth cloth;
  cloth.elastic = {0.0, 0.0, 0.0, 0.0};
  cloth.friction = {{0.0, 2.0, 0.0, 0.01}};
  ClothState state;
  Nominal p = pull(cloth, state, 0.0, 0.1, 500);
  EXPECT_NEAR(p.x / 1.1, 2.0 * (1.0 - std::exp(-green(0.1) / 0.01)), 1e-4);
  p = pull(cloth, state, 0.1, 0.09, 50);
  const double back = green(0.1) - green(0.09);
  EXPECT_NEAR(p.x / 1.09, -2.0 + 4.0 * std::exp(-back / 0.01), 2e-4);
}

// sigma = a + b (e - tau) + (b tau - a) exp(-e / tau) from rest
TEST(TwinCloth, FrictionThatGrowsWithStrainKeepsItsOffsetTerm) {
  Cloth cloth;
  cloth.elastic = {0.0, 0.0, 0.0, 0.0};
  cloth.friction = {{0.0, 1.0, 30.0, 0.02}};
  ClothState state;
  const Nominal p = pull(cloth, state, 0.0, 0.08, 400);
  const double e = green(0.08);
  EXPECT_NEAR(p.x / 1.08, 1.0 + 30.0 * (e - 0.02) + (30.0 * 0.02 - 1.0) * std::exp(-e / 0.02),
              1e-4);
}

TEST(TwinCloth, MaxwellRelaxesInAHold) {
  Cloth cloth;
  cloth.elastic = {0.0, 0.0, 0.0, 0.0};
  cloth.maxwell = {200.0, 0.0};
  cloth.relaxation_time_s = 5.0;
  ClothState state;
  const double before = pull(cloth, state, 0.0, 0.06, 300).x;
  // a ramp of nearly constant Green strain rate: q = k T rate (1 - exp(-t / T))
  EXPECT_NEAR(before / 1.06, 200.0 * 5.0 * green(0.06) / 6.0 * (1.0 - std::exp(-6.0 / 5.0)), 0.15);
  double after = 0.0;
  for (int k = 0; k < 200; ++k) after = step(cloth, 0.0, {1.06, 1.0, 0.0}, 0.05, state).x;
  EXPECT_NEAR(after / before, std::exp(-10.0 / 5.0), 1e-4);
}

TEST(TwinCloth, KelvinVoigtIsInProportionToRateAndDropsAtOnce) {
  Cloth cloth;
  cloth.elastic = {0.0, 0.0, 0.0, 0.0};
  cloth.kelvin_voigt = {50.0, 0.0};
  ClothState state;
  const Nominal p = pull(cloth, state, 0.0, 0.05, 2000);
  EXPECT_NEAR(p.x, 1.05 * 50.0 * 1.05 * 0.01, 1e-4);
  EXPECT_NEAR(step(cloth, 0.0, {1.05, 1.0, 0.0}, 1.0, state).x, 0.0, 1e-12);
}

TEST(TwinCloth, PlasticStrainGrowsWithNewMaximaOnly) {
  Cloth cloth;
  cloth.elastic.c12 = 0.0;
  cloth.plastic_share = {0.5, 0.0};
  cloth.yield_strain = 0.02;
  ClothState state;
  pull(cloth, state, 0.0, 0.06, 60);
  const double expected = 0.5 * (green(0.06) - 0.02);
  EXPECT_NEAR(state.plastic[0], expected, 1e-12);
  EXPECT_NEAR(pull(cloth, state, 0.06, 0.0, 60).x, -600.0 * expected, 1e-9);
  pull(cloth, state, 0.0, 0.05, 60);
  EXPECT_NEAR(state.plastic[0], expected, 1e-12);
}

TEST(TwinCloth, SofteningSparesTheFirstPullAndRejoinsItAtTheMaximum) {
  Cloth cloth, plain;
  cloth.softening = {0.2, 0.0};
  ClothState state, reference;
  const double first = pull(cloth, state, 0.0, 0.06, 60).x;
  EXPECT_NEAR(first, pull(plain, reference, 0.0, 0.06, 60).x, 1e-9);
  const double second = pull(cloth, state, 0.06, 0.03, 60).x;
  EXPECT_NEAR(second / pull(plain, reference, 0.06, 0.03, 60).x, 0.8, 2e-3);
  EXPECT_NEAR(pull(cloth, state, 0.03, 0.06, 60).x, first, 1e-9);
}

TEST(TwinCloth, AFreeDirectionHasNoStressAlsoWithFriction) {
  Cloth cloth;
  cloth.friction = {{std::numbers::pi / 2.0, 5.0, 0.0, 0.005},
                    {std::numbers::pi / 4.0, 5.0, 20.0, 0.01}};
  ClothState state;
  Deformation f;
  double largest = 0.0;
  for (int k = 0; k <= 400; ++k) {
    f.x = 1.0 + 0.08 * std::abs(std::sin(0.02 * k));
    largest = std::max(largest, std::abs(step_free(cloth, 0.0, false, f, 0.1, state).y));
  }
  EXPECT_LT(largest, 1e-7);
  EXPECT_LT(f.y, 1.0 - 1e-3);
}

}  // namespace
}  // namespace tenter::twin
