// SPDX-License-Identifier: GPL-3.0-or-later
// A sheet that falls on itself: no vertex goes through a triangle.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "server/mechanics/contact/crossings.h"
#include "server/mechanics/contact/point_triangle.h"
#include "server/mechanics/contact/self_contact.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/dynamics/motions.h"

namespace tenter::mechanics::testing {
namespace {

using tenter::testing::Numbers;

FourPoints random_case(Numbers& numbers, double size) {
  FourPoints x;
  for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = numbers.between(-size, size);
  return x;
}

/// The least over a fine grid of the triangle's points bounds the distance from above; its slope
/// against differences.
TEST(PointTriangle, IsTheNearestPointAndItsSlope) {
  Numbers numbers(3);
  for (int sample = 0; sample < 200; ++sample) {
    const FourPoints x = random_case(numbers, 1.0);
    const PairDistance near = point_triangle(x);
    double least = 1e9;
    constexpr int kFine = 60;
    for (int i = 0; i <= kFine; ++i)
      for (int j = 0; i + j <= kFine; ++j) {
        const Eigen::Vector3d w(static_cast<double>(i) / kFine, static_cast<double>(j) / kFine,
                                1.0 - static_cast<double>(i + j) / kFine);
        least = std::min(least, (x.col(0) - x.rightCols<3>() * w).norm());
      }
    ASSERT_GT(near.distance_m, 0.0);
    EXPECT_LE(near.distance_m, least + 1e-12);
    EXPECT_GE(near.distance_m, least - 0.05);
    EXPECT_EQ(near.weight[0], 1.0);
    EXPECT_NEAR(near.weight.sum(), 0.0, 1e-12);
    EXPECT_LE(near.weight.tail<3>().maxCoeff(), 1e-12);
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      constexpr double kStep = 1e-6;
      FourPoints low = x, high = x;
      low.data()[k] -= kStep;
      high.data()[k] += kStep;
      const double slope =
          (point_triangle(high).distance_m - point_triangle(low).distance_m) / (2.0 * kStep);
      EXPECT_NEAR(slope, near.weight[k / 3] * near.normal[k % 3],
                  2e-5 / std::min(1.0, near.distance_m));
    }
  }
}

/// Along random motions, most of which pass through: nothing touches within the free share.
TEST(PointTriangle, TheFreeShareIsFree) {
  Numbers numbers(5);
  int shortened = 0, whole = 0;
  for (int sample = 0; sample < 500; ++sample) {
    const FourPoints from = random_case(numbers, 1.0), to = random_case(numbers, 1.0);
    const double share = free_share(PairKind::vertex_and_triangle, from, to);
    const double first = point_triangle(from).distance_m;
    ASSERT_GE(share, 0.0);
    ASSERT_LE(share, 1.0);
    ++(share < 1.0 ? shortened : whole);
    for (int k = 0; k <= 200; ++k)
      ASSERT_GE(point_triangle(from + k / 200.0 * share * (to - from)).distance_m, 0.09 * first);
    if (share == 1.0) continue;
    // it ends where it had to: near
    EXPECT_LT(point_triangle(from + share * (to - from)).distance_m, 0.12 * first);
  }
  EXPECT_GT(shortened, 20);
  EXPECT_GT(whole, 100);
}

/// A strip folded over with a gap, its lower half held in a clip: gravity closes it.
struct Fold {
  Grid grid{4, 25, 0.015, 0.12};
  Sheet sheet{cloth_of_grid(grid, Diagonals::alternating).value(),
              linear_model({{"green_u", 100.0},
                            {"green_v", 100.0},
                            {"green_uv", 30.0},
                            {"bend_u", 1e-6},
                            {"bend_v", 1e-6},
                            {"bend_d", 1e-6}})};
  Boundary boundary;
  State state;
  Loads loads = weight(sheet.cloth.mesh, 0.15);

  Fold() {
    // half a turn of radius 5 mm in the middle of its length
    constexpr double kRadius = 0.005, kPi = 3.14159265358979323846;
    const double straight = 0.5 * (0.12 - kPi * kRadius);
    state.x = placed(sheet.cloth.mesh, [&](double u, double v) {
      if (v < straight) return Eigen::Vector3d(u, v, 0.0);
      const double turn = std::min((v - straight) / kRadius, kPi);
      const double back = std::max(0.0, v - straight - kPi * kRadius);
      return Eigen::Vector3d(u, straight + kRadius * std::sin(turn) - back,
                             kRadius * (1.0 - std::cos(turn)));
    });
    boundary.clips = {clip_on(
        "table",
        nodes_where(sheet.cloth.mesh, [&](double, double v) { return v < 0.95 * straight; }),
        state.x, {})};
    state.clips = {Pose{}};
  }

  /// Lowest vertex of the upper half, below which it has gone through.
  double lowest_m(bool keeps_apart, double& nearest_m, int& iterations) {
    auto stepper = TimeStepper::make(sheet.model, boundary).value();
    auto contact = SelfContact::make(sheet.cloth.mesh, 0.001, 0.5).value();
    if (keeps_apart) stepper.keep_apart(contact);
    const Script script = [&](double) { return StepInput{0.0, loads, {}, {}}; };
    Motion motion = at_rest(boundary, state);
    StepOptions options;
    options.scheme = TimeScheme::implicit_euler;
    StepLength length{.largest_s = 0.002};
    double lowest = 1.0;
    nearest_m = 0.001;
    for (int step = 1; step <= 60; ++step) {
      const auto end =
          walk_until(stepper, sheet.parameters, script, 0.002 * step, options, length, motion);
      if (!end || end->how != WalkEnd::How::complete) {
        ADD_FAILURE() << step << ": " << (end ? end->reason : end.error().message);
        return lowest;
      }
      iterations += end->iterations;
      nearest_m = std::min(nearest_m, contact.nearest_m(motion.at.x));
      for (int n = 0; n < sheet.nodes(); ++n)
        if (sheet.cloth.mesh.material_m(1, n) > 0.07)
          lowest = std::min(lowest, motion.at.x[3 * n + 2]);
    }
    return lowest;
  }
};

TEST(SelfContact, AFoldLiesOnItselfAndNothingPasses) {
  Fold fold;
  double nearest_m = 0.0;
  int iterations = 0;
  EXPECT_LT(fold.lowest_m(false, nearest_m, iterations), -0.005) << "left alone it goes through";
  iterations = 0;
  const double lowest_m = fold.lowest_m(true, nearest_m, iterations);
  EXPECT_GT(lowest_m, 0.0);
  EXPECT_LT(lowest_m, 0.001) << "it has come down";
  EXPECT_GT(nearest_m, 0.0);
  EXPECT_LT(nearest_m, 0.001);
  EXPECT_LT(iterations, 60 * 40);
}

/// Whether the vertex goes through the triangle on the straight way, by many looks at which side it
/// is on.
bool passes(const Eigen::VectorXd& from, const Eigen::VectorXd& to, const ContactPair& pair) {
  constexpr int kLooks = 40;
  double before = 0.0;
  for (int k = 0; k <= kLooks; ++k) {
    const double share = static_cast<double>(k) / kLooks;
    const FourPoints x = (1.0 - share) * pair_points(from, pair) + share * pair_points(to, pair);
    const Eigen::Vector3d p = x.col(0), a = x.col(1), b = x.col(2), c = x.col(3);
    const Eigen::Vector3d across = (b - a).cross(c - a);
    const double side = across.dot(p - a);
    const bool is_over = across.dot((b - a).cross(p - a)) > 0.0 &&
                         across.dot((c - b).cross(p - b)) > 0.0 &&
                         across.dot((a - c).cross(p - c)) > 0.0;
    if (k > 0 && is_over && side * before < 0.0) return true;
    before = side;
  }
  return false;
}

/// A strip rolled up as for the spirals of thesis 5.3.3, its inner end held, unrolls while gravity
/// pulls its turns together.
TEST(SelfContact, ARolledStripUnrollsWithoutPassingThroughItself) {
  const Grid grid{4, 81, 0.0075, 0.1};
  const Sheet sheet(cloth_of_grid(grid, Diagonals::alternating).value(),
                    linear_model({{"green_u", 60.0},
                                  {"green_v", 60.0},
                                  {"green_uv", 20.0},
                                  {"bend_u", 1e-5},
                                  {"bend_v", 1e-5},
                                  {"bend_d", 1e-5}}));
  const auto contact = SelfContact::make(sheet.cloth.mesh, 0.0005, 0.5);
  ASSERT_TRUE(contact) << contact.error().message;
  State state;
  state.x.resize(3 * static_cast<Eigen::Index>(sheet.nodes()));
  constexpr double kRadius = 0.004, kPitch = 0.0012 / 6.283185307179586;
  for (int j = 0; j < grid.nodes_v; ++j) {
    // turns at which the spiral has this length
    const double length = 0.1 * j / (grid.nodes_v - 1);
    const double turn = (std::sqrt(kRadius * kRadius + 2.0 * kPitch * length) - kRadius) / kPitch;
    const double radius = kRadius + kPitch * turn;
    for (int i = 0; i < grid.nodes_u; ++i)
      state.x.segment<3>(3 * static_cast<Eigen::Index>(grid.node(i, j))) << 0.0025 * i,
          radius * std::cos(turn), radius * std::sin(turn);
  }
  Boundary boundary;
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < grid.nodes_u; ++i) boundary.held.push_back(grid.node(i, j));
  const Loads loads = weight(sheet.cloth.mesh, 0.255);
  const Script script = [&](double) { return StepInput{0.0, loads, {}, {}}; };
  int passed[2] = {}, crossed[2] = {};
  for (const bool keeps_apart : {false, true}) {
    auto stepper = TimeStepper::make(sheet.model, boundary).value();
    if (keeps_apart) stepper.keep_apart(*contact);
    Motion motion = at_rest(boundary, state);
    StepOptions options;
    options.scheme = TimeScheme::implicit_euler;
    StepLength length{.largest_s = 0.002};
    NearPairs pairs(sheet.cloth.mesh);
    WalkHooks hooks;
    hooks.on_step = [&](const Motion& now) {
      pairs.find(now.last_points_m, now.at.x, 0.0);
      for (const ContactPair& pair : pairs.list())
        if (pair.kind == PairKind::vertex_and_triangle)
          passed[keeps_apart] += passes(now.last_points_m, now.at.x, pair);
      crossed[keeps_apart] += crossings(sheet.cloth.mesh, now.at.x);
      return true;
    };
    const auto end =
        walk_until(stepper, sheet.parameters, script, 0.06, options, length, motion, hooks);
    ASSERT_TRUE(end) << end.error().message;
    EXPECT_EQ(end->how, WalkEnd::How::complete) << end->reason;
  }
  EXPECT_GT(passed[0], 20) << "left alone its turns go through each other";
  EXPECT_GT(crossed[0], 20);
  EXPECT_EQ(passed[1], 0);
  EXPECT_EQ(crossed[1], 0);
}

TEST(SelfContact, DerivativesAndWhatDoesNotFit) {
  Fold fold;
  auto contact = SelfContact::make(fold.sheet.cloth.mesh, 0.0017, 2.0).value();
  Eigen::VectorXd x = fold.state.x;
  for (int n = 0; n < fold.sheet.nodes(); ++n)  // the upper half comes within reach
    if (fold.sheet.cloth.mesh.material_m(1, n) > 0.07) x[3 * n + 2] -= 0.009;
  x = shaken(x, 2e-4, 11);
  contact.begin(x);
  const auto energy_at = [&](const Eigen::VectorXd& at) {
    double energy = 0.0;
    contact.add(at, {&energy, nullptr, nullptr, nullptr}, 0.0);
    return energy;
  };
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(x.size());
  contact.add(x, {nullptr, gradient.data(), nullptr, nullptr}, 0.0);
  const double scale = gradient.lpNorm<Eigen::Infinity>();
  ASSERT_GT(scale, 1e-5);
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    constexpr double kStep = 1e-8;
    Eigen::VectorXd low = x, high = x;
    low[k] -= kStep;
    high[k] += kStep;
    EXPECT_NEAR((energy_at(high) - energy_at(low)) / (2.0 * kStep), gradient[k], 1e-4 * scale);
  }
  for (const auto& [thickness, stiffness] :
       {std::pair{0.0, 1.0}, std::pair{0.01, 1.0}, std::pair{0.001, 0.0}})
    EXPECT_FALSE(SelfContact::make(fold.sheet.cloth.mesh, thickness, stiffness));
}

}  // namespace
}  // namespace tenter::mechanics::testing
