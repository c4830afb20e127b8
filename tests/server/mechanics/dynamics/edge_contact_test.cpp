// SPDX-License-Identifier: GPL-3.0-or-later
// Edges that meet where no vertex does: distances, and a sheet that falls on another.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "server/mechanics/contact/crossings.h"
#include "server/mechanics/contact/edge_edge.h"
#include "server/mechanics/contact/self_contact.h"
#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/dynamics/motions.h"

namespace tenter::mechanics::testing {
namespace {

using tenter::testing::Numbers;

FourPoints random_edges(Numbers& numbers) {
  FourPoints x;
  for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = numbers.between(-1.0, 1.0);
  return x;
}

/// The least over a fine grid of points bounds the distance from above; slopes against differences.
TEST(EdgeEdge, IsTheNearestAndItsSlope) {
  Numbers numbers(7);
  for (int sample = 0; sample < 200; ++sample) {
    const FourPoints x = random_edges(numbers);
    const PairDistance near = edge_edge(x);
    double least = 1e9;
    constexpr int kFine = 60;
    for (int i = 0; i <= kFine; ++i)
      for (int j = 0; j <= kFine; ++j) {
        const double s = static_cast<double>(i) / kFine, t = static_cast<double>(j) / kFine;
        least = std::min(
            least,
            ((1.0 - s) * x.col(0) + s * x.col(1) - (1.0 - t) * x.col(2) - t * x.col(3)).norm());
      }
    ASSERT_GT(near.distance_m, 0.0);
    EXPECT_LE(near.distance_m, least + 1e-12);
    EXPECT_GE(near.distance_m, least - 0.05);
    EXPECT_NEAR(near.weight.head<2>().sum(), 1.0, 1e-12);
    EXPECT_NEAR(near.weight.tail<2>().sum(), -1.0, 1e-12);
    const EdgeCross cross = edge_cross(x);
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      constexpr double kStep = 1e-6;
      FourPoints low = x, high = x;
      low.data()[k] -= kStep;
      high.data()[k] += kStep;
      const double slope = (edge_edge(high).distance_m - edge_edge(low).distance_m) / (2.0 * kStep);
      EXPECT_NEAR(slope, near.weight[k / 3] * near.normal[k % 3],
                  1e-4 / std::min(1.0, near.distance_m));
      const double turning =
          (edge_cross(high).squared_m4 - edge_cross(low).squared_m4) / (2.0 * kStep);
      EXPECT_NEAR(turning, cross.slope.data()[k], 1e-7);
    }
  }
}

/// Parallel ones, and one that is a point.
TEST(EdgeEdge, WhereLinesSayNothing) {
  FourPoints x;
  x << 0, 1, 0.5, 3, 0, 0, 2, 2, 0, 0, 0, 0;
  EXPECT_NEAR(edge_edge(x).distance_m, 2.0, 1e-15);
  x << 0, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0;
  EXPECT_NEAR(edge_edge(x).distance_m, 1.0, 1e-15);
  x << 0, 1, 0.5, 0.5, 0, 0, 3, 3, 0, 0, 0, 0;
  EXPECT_NEAR(edge_edge(x).distance_m, 3.0, 1e-15);
}

TEST(EdgeEdge, TheFreeShareIsFree) {
  Numbers numbers(9);
  int shortened = 0, whole = 0;
  for (int sample = 0; sample < 500; ++sample) {
    const FourPoints from = random_edges(numbers), to = random_edges(numbers);
    const double share = free_share(PairKind::two_edges, from, to);
    const double first = edge_edge(from).distance_m;
    ASSERT_GE(share, 0.0);
    ASSERT_LE(share, 1.0);
    ++(share < 1.0 ? shortened : whole);
    for (int k = 0; k <= 200; ++k)
      ASSERT_GE(edge_edge(from + k / 200.0 * share * (to - from)).distance_m, 0.09 * first);
    if (share == 1.0) continue;
    EXPECT_LT(edge_edge(from + share * (to - from)).distance_m, 0.12 * first);
  }
  EXPECT_GT(shortened, 20);
  EXPECT_GT(whole, 100);
}

/// Two strips of long triangles, one across the other: each has its vertices beside the other.
struct Cross {
  static constexpr int kNodes = 8;  // of each strip
  Sheet sheet;
  Boundary boundary;
  State state;
  Loads loads;

  static Cloth cloth() {
    SurfaceMesh mesh;
    mesh.material_m.resize(2, 2 * kNodes);
    for (int strip = 0; strip < 2; ++strip)
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 2; ++j)
          mesh.material_m.col(node(strip, i, j)) << 0.04 * i, 0.02 * j + 0.1 * strip;
    for (int strip = 0; strip < 2; ++strip)
      for (int i = 0; i < 3; ++i) {
        const int a = node(strip, i, 0), b = node(strip, i + 1, 0);
        const int c = node(strip, i + 1, 1), d = node(strip, i, 1);
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      }
    return cloth_of_mesh(mesh).value();
  }
  static int node(int strip, int i, int j) { return kNodes * strip + 2 * i + j; }

  Cross()
      : sheet(cloth(), linear_model({{"green_u", 100.0},
                                     {"green_v", 100.0},
                                     {"green_uv", 30.0},
                                     {"bend_u", 1e-5},
                                     {"bend_d", 1e-5}})),
        loads(weight(sheet.cloth.mesh, 0.15)) {
    state.x.resize(3 * static_cast<Eigen::Index>(sheet.nodes()));
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 2; ++j) {
        const double along = 0.04 * i - 0.06, across = 0.02 * j - 0.01;
        place(node(0, i, j)) << along, across, 0.0;
        // a little aside and aslant: nothing is exactly above anything
        place(node(1, i, j)) << 0.002 - across, along + 0.003, 0.005 - 0.2 * across;
        boundary.held.push_back(node(0, i, j));
      }
  }
  Eigen::Map<Eigen::Vector3d> place(int n) {
    return Eigen::Map<Eigen::Vector3d>(state.x.data() + 3 * static_cast<Eigen::Index>(n));
  }
  /// Middle of the upper strip's long edges above the lower one.
  static double middle_m(const Eigen::VectorXd& x) {
    double sum = 0.0;
    for (const int i : {1, 2})
      for (const int j : {0, 1}) sum += x[3 * node(1, i, j) + 2];
    return sum / 4.0;
  }
};

TEST(EdgeContact, AStripLiesAcrossAnotherThoughNoVertexMeetsATriangle) {
  Cross cross;
  const auto contact = SelfContact::make(cross.sheet.cloth.mesh, 0.002, 1.0);
  ASSERT_TRUE(contact) << contact.error().message;
  int crossed[2] = {}, vertices = 0, edges = 0;
  double middle_m[2] = {};
  for (const bool keeps_apart : {false, true}) {
    auto stepper = TimeStepper::make(cross.sheet.model, cross.boundary).value();
    if (keeps_apart) stepper.keep_apart(*contact);
    Motion motion = at_rest(cross.boundary, cross.state);
    NearPairs pairs(cross.sheet.cloth.mesh);
    const Script script = [&](double) { return StepInput{0.0, cross.loads, {}, {}}; };
    StepOptions options;
    options.scheme = TimeScheme::implicit_euler;
    StepLength length{.largest_s = 0.004};
    WalkHooks hooks;
    hooks.on_step = [&](const Motion& now) {
      crossed[keeps_apart] += crossings(cross.sheet.cloth.mesh, now.at.x) > 0;
      if (!keeps_apart) return true;
      pairs.find(now.at.x, now.at.x, 0.002);
      for (const ContactPair& pair : pairs.list()) {
        if (pair_distance(pair.kind, pair_points(now.at.x, pair)).distance_m > 0.002) continue;
        ++(pair.kind == PairKind::two_edges ? edges : vertices);
      }
      return true;
    };
    const auto end =
        walk_until(stepper, cross.sheet.parameters, script, 0.08, options, length, motion, hooks);
    ASSERT_TRUE(end) << end.error().message;
    EXPECT_EQ(end->how, WalkEnd::How::complete) << end->reason;
    middle_m[keeps_apart] = Cross::middle_m(motion.at.x);
  }
  EXPECT_LT(middle_m[0], -0.02) << "left alone it falls through";
  EXPECT_GT(crossed[0], 0);
  EXPECT_GT(middle_m[1], 0.0);
  EXPECT_EQ(crossed[1], 0);
  EXPECT_GT(edges, 0);
  EXPECT_EQ(vertices, 0) << "vertices and triangles alone would not have held it";
}

TEST(EdgeContact, CrossingsAreCounted) {
  Cross cross;
  EXPECT_EQ(crossings(cross.sheet.cloth.mesh, cross.state.x), 0);
  // the upper one dips through the lower: its two long edges and the diagonal between them pierce
  // triangles, and so does the lower one's diagonal
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 2; ++j) {
      auto place = cross.place(Cross::node(1, i, j));
      place.z() = 0.3 * place.y();
    }
  EXPECT_EQ(crossings(cross.sheet.cloth.mesh, cross.state.x), 4);
}

/// Forces of pairs of edges, some of them so nearly parallel that they fade.
TEST(EdgeContact, ForcesAreTheSlopeOfTheEnergy) {
  for (const double turned_rad : {0.7, 0.01}) {
    Cross cross;
    auto contact = SelfContact::make(cross.sheet.cloth.mesh, 0.004, 2.0).value();
    // the upper strip turned until it nearly lies along the lower, with its ends over the middle
    const double angle = turned_rad - 0.5 * 3.14159265358979323846;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 2; ++j) {
        auto place = cross.place(Cross::node(1, i, j));
        const Eigen::Vector3d turned = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * place;
        place << turned.x() + 0.011, turned.y() + 0.004, 0.0015 + 0.01 * turned.y();
      }
    const Eigen::VectorXd x = cross.state.x;
    contact.begin(x);
    const auto energy_at = [&](const Eigen::VectorXd& at) {
      double energy = 0.0;
      contact.add(at, {&energy, nullptr, nullptr, nullptr}, 0.0);
      return energy;
    };
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(x.size());
    contact.add(x, {nullptr, gradient.data(), nullptr, nullptr}, 0.0);
    const double scale = gradient.lpNorm<Eigen::Infinity>();
    ASSERT_GT(scale, 1e-4);
    int fading = 0;
    NearPairs pairs(cross.sheet.cloth.mesh);
    pairs.find(x, x, 0.004);
    for (const ContactPair& pair : pairs.list())
      fading += pair.kind == PairKind::two_edges &&
                edge_edge(pair_points(x, pair)).distance_m < 0.004 &&
                edge_cross(pair_points(x, pair)).squared_m4 < 1e-3 * pair.squares_m4;
    EXPECT_EQ(fading > 2, turned_rad < 0.03);
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      constexpr double kStep = 1e-8;
      Eigen::VectorXd low = x, high = x;
      low[k] -= kStep;
      high[k] += kStep;
      EXPECT_NEAR((energy_at(high) - energy_at(low)) / (2.0 * kStep), gradient[k], 1e-4 * scale);
    }
  }
}

}  // namespace
}  // namespace tenter::mechanics::testing
