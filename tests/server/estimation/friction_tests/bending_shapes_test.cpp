// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "server/estimation/friction_tests/bending/bending_fit.h"
#include "server/estimation/friction_tests/bending/contour/contour_errors.h"
#include "tests/server/estimation/friction_tests/derivatives.h"
#include "tests/twin/friction/hanging_strip.h"

namespace tenter::estimation {
namespace {

constexpr double kGravity = 9.81;
constexpr double kLength = 0.1;
const twin::FrictionSample& felt() {
  return twin::bending_samples()[0];
}
const twin::FrictionSample& paper() {
  return twin::bending_samples()[2];
}

Eigen::VectorXd parameters_of(const twin::FrictionSample& cloth) {
  return flat({cloth.k1, cloth.k2, cloth.a, cloth.b, cloth.tau});
}

StrainPoint point() {
  return *StrainPoint::make(friction_model("bend_v"));
}

BendingTests tests_of(const twin::FrictionSample& cloth, const std::vector<double>& radii_mm,
                      double noise_m, std::uint64_t seed) {
  BendingTests tests;
  tests.area_density_kg_m2 = cloth.density_kg_m2;
  tests.gravity_m_s2 = kGravity;
  for (const double radius : radii_mm) {
    twin::StripPlan plan;
    plan.radius_m = 1e-3 * radius;
    if (radius == 0.0) plan.clamp_angle_rad = twin::kCantileverAngle;
    StripTest strip;
    for (const twin::StripPoint& p :
         twin::photographed(twin::resting_strip(cloth, plan), noise_m, seed++))
      strip.points.push_back({p.x_m, p.y_m});
    strip.length_m = plan.length_m;
    strip.radius_m = plan.radius_m;
    tests.strips.push_back(std::move(strip));
  }
  return tests;
}

// Paper's friction grows faster with the curvature than its elastic torque does: going back from a
// cylinder the stress falls, and the torque that it held there is held on.
TEST(OneWay, NeverFallsAndIsLevelOverASnap) {
  const Eigen::VectorXd p = parameters_of(paper());
  const StrainPoint law = point();
  const double anchor = 300.0;
  OneWay way(law, anchor, 450.0, p);
  StrainPoint::Walk walk;
  law.begin(walk);
  law.to_strain(anchor, p, walk);
  double last = way.at(anchor).torque;
  double level = 0.0, highest_gap = 0.0, as_law = 0.0;
  for (double strain = anchor; strain > -100.0; strain -= 0.25) {
    const OneWay::Value value = way.at(strain);
    ASSERT_LE(value.torque, last + 1e-15) << strain;
    last = value.torque;
    double torque = 0.0, tangent = 0.0;
    law.look(strain, p, false, walk, torque, tangent);
    if (value.law_at != strain) {
      EXPECT_TRUE(value.is_past);
      EXPECT_EQ(value.tangent, 0.0);
      highest_gap = std::max(highest_gap, torque - value.torque);
      level += 0.25;
    } else {
      EXPECT_EQ(value.torque, torque);
      as_law += 0.25;
    }
  }
  EXPECT_GT(level, 40.0);   // 1/m: the snap is wide
  EXPECT_GT(as_law, 40.0);  // and not all there is
  EXPECT_GT(highest_gap, 0.1 * std::abs(last));
}

TEST(OneWay, MeetsALineOnEitherSideOfASnapAndOnIt) {
  const Eigen::VectorXd p = parameters_of(paper());
  const StrainPoint law = point();
  OneWay way(law, 300.0, 450.0, p);
  const double softness = way.softness();
  ASSERT_GT(softness, 0.0);
  for (const double strain : {-20.0, 5.0, 40.0, 90.0, 200.0, 299.0, 301.0, 350.0}) {
    const double sum = strain + softness * way.at(strain).torque;
    for (double guess : {-80.0, 60.0, 320.0}) {
      way.meeting(sum, softness, guess);
      EXPECT_NEAR(guess, strain, 1e-9 * 300.0) << strain;
    }
  }
}

TEST(OneWay, MovesWithItsParametersOnASnapToo) {
  const Eigen::VectorXd p = parameters_of(paper());
  const StrainPoint law = point();
  for (const double strain : {40.0, 250.0, -30.0}) {
    OneWay way(law, 300.0, 450.0, p);
    const Eigen::VectorXd exact = way.torque_by_p(way.at(strain).law_at);
    for (const int k : {kK1, kK2, kA, kB, kTau}) {
      const auto at = [&](double value) {
        Eigen::VectorXd moved = p;
        moved[k] = value;
        return OneWay(law, 300.0, 450.0, moved).at(strain).torque;
      };
      const double slope = testing::difference(at, p[k], 1e-4 * p[k]);
      EXPECT_NEAR(exact[k], slope, 1e-5 * std::abs(slope)) << strain << " " << k;
    }
  }
}

// The twin is a chain of stiff segments that creeps to rest, with its law as a table of small
// steps: of this solver it shares nothing but the mechanics.
TEST(RestingShape, IsThatOfTheTwin) {
  for (const double radius_mm : {5.0, 10.0, 31.5}) {
    twin::StripPlan plan;
    plan.radius_m = 1e-3 * radius_mm;
    const twin::RestingStrip strip = twin::resting_strip(felt(), plan);
    ASSERT_TRUE(strip.is_at_rest);
    const Eigen::VectorXd p = parameters_of(felt());
    const StrainPoint law = point();
    OneWay way(law, 3.0 / plan.radius_m, 1500.0, p);
    constexpr int kCells = 240;
    RestingShape shape(kLength, felt().density_kg_m2 * kGravity, Eigen::VectorXd::Zero(kCells), {});
    Eigen::VectorXd guess(kCells + 1);
    guess[0] = plan.clamp_angle_rad;
    for (int i = 0; i < kCells; ++i)
      guess[i + 1] = guess[i] + strip.strain[static_cast<std::size_t>(i * plan.hinges / kCells)] /
                                    3.0 * kLength / kCells;
    const Eigen::Vector3d clamp(0.0, 0.0, plan.clamp_angle_rad);
    ASSERT_TRUE(shape.rest(way, clamp, guess)) << radius_mm;
    double farthest = 0.0;
    for (std::size_t i = 0; i < strip.points.size(); ++i) {
      const RestingShape::Place at = shape.place(kLength * static_cast<double>(i) / plan.hinges);
      farthest =
          std::max(farthest, std::hypot(at.x - strip.points[i].x_m, at.y - strip.points[i].y_m));
    }
    EXPECT_LT(farthest, 5e-5) << radius_mm;  // segments of half a millimetre
    EXPECT_GT(std::abs(shape.directions()[kCells] - plan.clamp_angle_rad), 0.5);
  }
}

// With a piece in the middle of which the law says nothing.
TEST(RestingShape, MovesWithItsPlacement) {
  const Eigen::VectorXd p = parameters_of(felt());
  const StrainPoint law = point();
  OneWay way(law, 100.0, 300.0, p);
  constexpr int kCells = 60;
  RestingShape shape(kLength, felt().density_kg_m2 * kGravity,
                     Eigen::VectorXd::Constant(kCells, 40.0), {{24, 36, 2}});
  ASSERT_EQ(shape.placement_count(), 5);
  Eigen::VectorXd placement(5);
  placement << 0.01, -0.02, -1.6, 0.02, -0.03;
  const Eigen::VectorXd guess = Eigen::VectorXd::LinSpaced(kCells + 1, -1.6, 0.0);
  ASSERT_TRUE(shape.rest(way, placement, guess));
  shape.differentiate(way, kFrictionParameters);
  Eigen::Matrix<double, 3, Eigen::Dynamic> exact;
  for (const double arc : {0.013, 0.0605, 0.1}) {
    shape.place_by(arc, exact);
    for (int k = 0; k < placement.size(); ++k) {
      const auto at = [&](double value) -> Eigen::Vector3d {
        Eigen::VectorXd moved = placement;
        moved[k] = value;
        RestingShape other = shape;
        EXPECT_TRUE(other.rest(way, moved, guess));
        const RestingShape::Place place = other.place(arc);
        return {place.x, place.y, place.direction};
      };
      const Eigen::Vector3d slope = testing::difference(at, placement[k], 1e-5);
      EXPECT_LT((exact.col(kFrictionParameters + k) - slope).norm(), 1e-6 * (1.0 + slope.norm()))
          << arc << " " << k;
      if (arc == 0.1) {
        EXPECT_GT(slope.norm(), 0.01) << k;  // rad or m by m or rad
      }
    }
  }
}

TEST(ContourErrors, HaveTheirDerivatives) {
  const twin::FrictionSample& cloth = twin::bending_samples()[1];
  const auto profiles = sampled(tests_of(cloth, {0.0, 10.0, 31.5}, 1e-4, 1));
  ASSERT_TRUE(profiles);
  ContourErrors errors(point(), std::make_shared<const std::vector<ProfileSamples>>(*profiles));
  const Eigen::VectorXd p =
      flat({1.1 * cloth.k1, cloth.k2, cloth.a, 0.8 * cloth.b, 1.2 * cloth.tau});
  ASSERT_EQ(errors.set_reference(p), mechanics::PathStatus::ok);
  testing::expect_derivatives(errors, p, {kK1, kK2, kA, kB, kTau});
}

// At the true numbers what is left is the noise of the points, and no more of it than the placement
// takes: for felt, which rests at the torque of a snap, and for paper, which snaps far.
TEST(ContourErrors, AreTheNoiseAtTheTruth) {
  for (const twin::FrictionSample* cloth : {&felt(), &paper()}) {
    const auto profiles = sampled(tests_of(*cloth, {5.0, 10.0, 23.0}, 1e-4, 11));
    ASSERT_TRUE(profiles);
    ContourErrors errors(point(), std::make_shared<const std::vector<ProfileSamples>>(*profiles));
    const Eigen::VectorXd p = parameters_of(*cloth);
    ASSERT_EQ(errors.set_reference(p), mechanics::PathStatus::ok);
    Eigen::VectorXd residuals;
    ASSERT_EQ(errors.evaluate(p, residuals, nullptr), mechanics::PathStatus::ok);
    const auto rows = static_cast<double>(residuals.size());
    ASSERT_GT(rows, 200.0);
    EXPECT_GT(errors.snapped(), 0);
    // four standard deviations of chi-squared to either side
    EXPECT_NEAR(residuals.squaredNorm() / rows, 1.0, 4.0 * std::sqrt(2.0 / rows) + 12.0 / rows)
        << cloth->name;
  }
}

// Where a snap holds the strip upright the clamp's direction hardly moves the points: the best
// placement is the same wherever it is looked for from.
TEST(ContourErrors, PlaceAStripInOneWay) {
  const auto profiles = sampled(tests_of(paper(), {5.0, 10.0, 23.0, 31.5}, 1e-4, 11));
  ASSERT_TRUE(profiles);
  ContourErrors errors(point(), std::make_shared<const std::vector<ProfileSamples>>(*profiles));
  const Eigen::VectorXd p = parameters_of(paper());
  const auto misfit_at = [&](const Eigen::VectorXd& parameters) {
    EXPECT_EQ(errors.set_reference(parameters), mechanics::PathStatus::ok);
    Eigen::VectorXd residuals;
    EXPECT_EQ(errors.evaluate(parameters, residuals, nullptr), mechanics::PathStatus::ok);
    return residuals.squaredNorm();
  };
  const double fresh = misfit_at(p);
  EXPECT_GT(errors.snapped(), 0);
  ASSERT_GT(fresh, 500.0);
  for (const double factor : {0.98, 1.02, 1.04}) {
    Eigen::VectorXd elsewhere = p;
    elsewhere[kB] *= factor;
    EXPECT_GT(misfit_at(elsewhere), fresh + 10.0) << factor;
    EXPECT_NEAR(misfit_at(p), fresh, 0.1) << factor;
  }
}

// Of a tightly rolled strip of paper one piece in five goes one way; the others' points tell where
// the weight hangs that bends it.
TEST(ContourErrors, CountThePointsOfPiecesLeftOut) {
  const auto profiles = sampled(tests_of(paper(), {5.0}, 1e-4, 3));
  ASSERT_TRUE(profiles);
  const ProfileSamples& profile = profiles->front();
  ASSERT_GE(profile.left_out, 3);
  ASSERT_FALSE(profile.samples.empty());
  ContourErrors errors(point(), std::make_shared<const std::vector<ProfileSamples>>(*profiles));
  const auto rows = static_cast<double>(profile.points.size()) + 2.0;
  EXPECT_EQ(errors.row_count(), rows);
  const Eigen::VectorXd p = parameters_of(paper());
  ASSERT_EQ(errors.set_reference(p), mechanics::PathStatus::ok);
  Eigen::VectorXd residuals;
  ASSERT_EQ(errors.evaluate(p, residuals, nullptr), mechanics::PathStatus::ok);
  // the turns of what is held take no more than their number
  const double turns = 2.0 * profile.intervals;
  EXPECT_LT(residuals.squaredNorm(), rows + 4.0 * std::sqrt(2.0 * rows));
  EXPECT_GT(residuals.squaredNorm(), rows - turns - 4.0 * std::sqrt(2.0 * rows));
}

TEST(Bending, GivesPaperBackThoughMostOfItsSpiralsIsLeftOut) {
  const auto found =
      fit_bending(tests_of(paper(), {0.0, 0.0, 4.0, 5.0, 7.0, 10.0, 16.0, 31.5, 50.0}, 1e-4, 41),
                  "bend_v", {.profiles = false});
  ASSERT_TRUE(found) << found.error().message;
  const FitResult& fit = found->friction.fit;
  EXPECT_LT(fit.chi2, static_cast<double>(fit.residuals.size()));
  const std::array<double, 5> truth = {paper().k1, paper().k2, paper().a, paper().b, paper().tau};
  const std::array<int, 5> places = {kK1, kK2, kA, kB, kTau};
  // k2 of eight strips: were the points left out not counted, 39 would tell it to 2.7 % only
  const std::array<double, 5> width = {0.01, 0.01, 2.0, 0.01, 0.004};
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const FrictionNumber& number = found->friction.numbers[k];
    ASSERT_TRUE(number.hi) << number.name;
    const double error = (*number.hi - number.value) / 1.96;
    EXPECT_LT(std::abs(fit.parameters[places[k]] - truth[k]), 3.0 * error) << number.name;
    EXPECT_LT(error, width[k] * truth[k]) << number.name;
  }
}

TEST(Bending, GivesFeltBackThatRestsAtASnap) {
  const auto found =
      fit_bending(tests_of(felt(), {0.0, 0.0, 4.0, 6.0, 10.0, 16.0, 23.0, 31.5}, 1e-4, 21),
                  "bend_v", {.profiles = false});
  ASSERT_TRUE(found) << found.error().message;
  const std::array<double, 5> truth = {felt().k1, felt().k2, felt().a, felt().b, felt().tau};
  const std::array<double, 5> width = {0.05, 0.05, 0.05, 0.05, 0.02};
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const FrictionNumber& number = found->friction.numbers[k];
    ASSERT_TRUE(number.lo && number.hi) << number.name;
    // three standard errors, which are a few hundredths of the number
    EXPECT_LT(std::abs(number.value - truth[k]), 0.77 * (*number.hi - *number.lo)) << number.name;
    EXPECT_LT(*number.hi - *number.lo, 2.0 * width[k] * truth[k]) << number.name;
  }
  EXPECT_GT(found->friction.snapped, 0);
  std::size_t kept = 0;
  for (const ProfileSamples& profile : found->profiles) kept += profile.samples.size();
  EXPECT_EQ(found->predicted.size(), kept);
}

}  // namespace
}  // namespace tenter::estimation
