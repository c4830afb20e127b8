// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "server/estimation/friction_tests/bending/bending_fit.h"
#include "server/estimation/friction_tests/bending/torque_errors.h"
#include "tests/server/estimation/friction_tests/derivatives.h"
#include "tests/twin/friction/hanging_strip.h"

namespace tenter::estimation {
namespace {

constexpr double kGravity = 9.81;

std::vector<ContourPoint> profile_of(const twin::RestingStrip& strip, double noise_m,
                                     std::uint64_t seed) {
  std::vector<ContourPoint> points;
  for (const twin::StripPoint& p : twin::photographed(strip, noise_m, seed))
    points.push_back({p.x_m, p.y_m});
  return points;
}

/// A strip without weight keeps the cylinder's circle, where friction holds it: here, any circle.
std::vector<ContourPoint> circle(double radius_m, double length_m, int count) {
  std::vector<ContourPoint> points;
  for (int i = 0; i < count; ++i) {
    const double angle = length_m * i / (count - 1) / radius_m;
    points.push_back({radius_m * std::sin(angle), radius_m * (1.0 - std::cos(angle))});
  }
  return points;
}

BendingTests tests_of(const twin::FrictionSample& sample, const std::vector<double>& radii_mm,
                      double noise_m) {
  BendingTests tests;
  tests.area_density_kg_m2 = sample.density_kg_m2;
  tests.gravity_m_s2 = kGravity;
  std::uint64_t seed = 1;
  for (const double radius : radii_mm) {
    twin::StripPlan plan;
    plan.radius_m = 1e-3 * radius;
    if (radius == 0.0) {
      plan.clamp_angle_rad = twin::kCantileverAngle;
      plan.length_m = 0.06;
    }
    const twin::RestingStrip strip = twin::resting_strip(sample, plan);
    tests.strips.push_back({profile_of(strip, noise_m, seed++), plan.length_m, plan.radius_m});
  }
  return tests;
}

TEST(ProfileCurve, FollowsACircleRoundMoreThanOneTurn) {
  const double radius = 0.01;
  const auto curve = ProfileCurve::fitted(circle(radius, 0.1, 201), {.length_m = 0.1});
  ASSERT_TRUE(curve) << curve.error().message;
  const double weight = 2.0;
  for (const double arc : {0.0, 0.013, 0.05, 0.099}) {
    EXPECT_NEAR(curve->curvature(arc), 1.0 / radius, 1e-3 / radius);
    EXPECT_NEAR(curve->direction(arc), arc / radius, 1e-3);
    // integral of (L - t) cos(t / r) from s to L
    const double u = arc / radius, v = 0.1 / radius;
    const double integral = radius * radius * (-(v - u) * std::sin(u) + std::cos(u) - std::cos(v));
    EXPECT_NEAR(curve->torque(arc, weight), -weight * integral, 1e-4 * weight * radius * 0.1);
  }
}

TEST(ProfileCurve, KnowsItsScatter) {
  const twin::FrictionSample& cloth = twin::bending_samples()[1];
  const twin::RestingStrip strip = twin::resting_strip(cloth, {.radius_m = 0.0275});
  const double weight = cloth.density_kg_m2 * kGravity;
  double strain_score = 0.0, torque_score = 0.0;
  constexpr int kSeeds = 30;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const auto curve =
        ProfileCurve::fitted(profile_of(strip, 1e-4, static_cast<std::uint64_t>(seed)),
                             {.length_m = 0.1, .intervals = 12});
    ASSERT_TRUE(curve);
    EXPECT_NEAR(curve->noise_m(), 1e-4, 0.3e-4);
    double truth = 0.0;
    for (std::size_t i = 80; i < 120; ++i)
      truth += 0.5 * (strip.strain[i] + strip.strain[i + 1]) / 40.0;
    const Eigen::VectorXd g =
        150.0 * (curve->direction_by_coefficients(0.06) - curve->direction_by_coefficients(0.04));
    const double off = 150.0 * (curve->direction(0.06) - curve->direction(0.04)) - truth;
    strain_score += off * off / g.dot(curve->covariance() * g);
    const Eigen::VectorXd t = curve->torque_by_coefficients(0.05, weight);
    const double torque_off = curve->torque(0.05, weight) - strip.torque_N[100];
    torque_score += torque_off * torque_off / t.dot(curve->covariance() * t);
  }
  // chi-squared of 30: 15 to 51 but once in a hundred
  EXPECT_GT(strain_score, 13.0);
  EXPECT_LT(strain_score, 54.0);
  EXPECT_GT(torque_score, 13.0);
  EXPECT_LT(torque_score, 54.0);
}

TEST(StripTests, PartTheSensesAndRefuseWhatTheyCannotUse) {
  BendingTests tests;
  EXPECT_FALSE(check(tests));
  tests.area_density_kg_m2 = 0.2;
  tests.strips.push_back({circle(0.02, 0.1, 50), 0.1, 0.01});
  std::vector<ContourPoint> mirrored = circle(0.02, 0.1, 50);
  for (ContourPoint& point : mirrored) point.y_m = -point.y_m;
  tests.strips.push_back({mirrored, 0.1, 0.0});
  EXPECT_TRUE(check(tests));
  const auto parts = by_sense(tests);
  ASSERT_EQ(parts[0].strips.size(), 1U);
  ASSERT_EQ(parts[1].strips.size(), 1U);
  const auto curve = ProfileCurve::fitted(parts[1].strips[0].points, {.length_m = 0.1});
  ASSERT_TRUE(curve);
  EXPECT_NEAR(curve->curvature(0.05), 50.0, 0.5);
  EXPECT_FALSE(check(parts[1]));  // no spiral among them
  tests.strips[1].length_m = 0.0;
  const auto refused = check(tests);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("strip 2"), std::string::npos);
}

TEST(TorqueErrors, HaveTheirDerivatives) {
  const twin::FrictionSample& cloth = twin::bending_samples()[1];
  const auto profiles = sampled(tests_of(cloth, {0.0, 10.0, 31.5}, 1e-4));
  ASSERT_TRUE(profiles);
  TorqueErrors errors(*StrainPoint::make(friction_model("bend_v")),
                      std::make_shared<const std::vector<ProfileSamples>>(*profiles));
  Eigen::VectorXd p(static_cast<Eigen::Index>(kFrictionParameters));
  p << 1.1 * cloth.k1, cloth.k2, cloth.a, 0.8 * cloth.b, 0.0, 1.2 * cloth.tau;
  ASSERT_EQ(errors.set_reference(p), mechanics::PathStatus::ok);
  testing::expect_derivatives(errors, p, {kK1, kK2, kA, kB, kTau});
}

TEST(Bending, GivesBackTheTableFromAFewStrips) {
  const twin::FrictionSample& cloth = twin::bending_samples()[1];
  const auto found =
      fit_bending(tests_of(cloth, {0.0, 0.0, 5.0, 10.0, 16.0, 23.0, 31.5, 50.0}, 2e-5), "bend_v",
                  {.profiles = false});
  ASSERT_TRUE(found) << found.error().message;
  const std::array<double, 5> truth = {cloth.k1, cloth.k2, cloth.a, cloth.b, cloth.tau};
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const FrictionNumber& number = found->friction.numbers[k];
    ASSERT_TRUE(number.lo && number.hi) << number.name;
    EXPECT_LT(std::abs(number.value - truth[k]), *number.hi - *number.lo) << number.name;
  }
  EXPECT_NEAR(found->friction.numbers[2].value, cloth.a, 0.05 * cloth.a);
  EXPECT_NEAR(found->friction.numbers[4].value, cloth.tau, 0.1 * cloth.tau);
  // a strip that bends from flat looks stiffer than it is
  EXPECT_GT(found->cantilever.k1, 1.3 * cloth.k1);
}

}  // namespace
}  // namespace tenter::estimation
