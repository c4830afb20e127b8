// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/conditions/contact.h"

#include <gtest/gtest.h>

#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

constexpr double kDensity = 0.2;

model::Model draping_cloth() {
  return preset_with("cloth_stvk", {{"weft", 200.0},
                                    {"warp", 250.0},
                                    {"shear", 40.0},
                                    {"bend_weft", 2e-5},
                                    {"bend_warp", 2e-5},
                                    {"bend_diagonal", 2e-5}});
}

struct Touching {
  double force_N = 0.0;                            ///< of all nodes
  Eigen::Vector3d push = Eigen::Vector3d::Zero();  ///< the same as vectors
  double deepest_m = 0.0;
  double worst_gap_m = 0.0;  ///< of a node that is pressed
  int nodes = 0;
};

Touching touching(const Sheet& sheet, const Boundary& boundary,
                  const std::vector<Obstacle>& obstacles, const State& state,
                  const EquilibriumResult& result) {
  const Unknowns unknowns(boundary, sheet.model.matrix());
  Touching sum;
  Eigen::Index k = 0;
  for (const Obstacle& obstacle : obstacles) {
    for (const int node : unknowns.free_nodes()) {
      const Gap g = gap(obstacle, state.x.segment<3>(3 * node));
      const double force = result.contact_force_N[k++];
      EXPECT_GE(force, 0.0);
      sum.force_N += force;
      sum.push += force * g.normal;
      sum.deepest_m = std::max(sum.deepest_m, -g.value_m);
      if (force <= 0.0) continue;
      sum.worst_gap_m = std::max(sum.worst_gap_m, g.value_m);
      ++sum.nodes;
    }
  }
  return sum;
}

// A square let down on a floor, from above it and from a crumpled state: it lies flat, and the
// floor bears its weight.
TEST(Contact, AFloorBearsTheWeight) {
  const Sheet sheet(cloth_of_grid({9, 9, 0.1, 0.1}, Diagonals::alternating).value(),
                    draping_cloth());
  const std::vector<Obstacle> floor = {Plane{{0.0, 0.0, -0.01}, Eigen::Vector3d::UnitZ()}};
  const Loads loads = weight(sheet.cloth.mesh, kDensity);
  const double weight_N = kDensity * 0.01 * 9.81;
  Boundary boundary;  // one node is held sideways by being held: the floor has no friction
  boundary.held = {40};
  for (const double shake : {0.0, 0.002}) {
    State state{shaken(flat(sheet.cloth.mesh), shake, 3), {}};
    state.x.segment<3>(3 * 40) << sheet.cloth.mesh.material_m.col(40), -0.01;
    EquilibriumOptions options;
    const EquilibriumResult result = solved(sheet, boundary, loads, state, options, floor);
    ASSERT_TRUE(result.is_good(options)) << describe(result, options);
    const Touching touch = touching(sheet, boundary, floor, state, result);
    const double of_held_N = loads.node_mass_kg[40] * 9.81;
    EXPECT_EQ(touch.nodes, 80);
    EXPECT_NEAR(touch.force_N, weight_N - of_held_N, 1e-4 * weight_N);
    EXPECT_LE(touch.deepest_m, options.contact_depth_m);
    // the floor alone presses at what is free
    EXPECT_NEAR(result.by_node[3 * 40 + 2], of_held_N, 1e-4 * weight_N);
  }
}

// A tent: the middle is held above the floor, the rest hangs down to it.
TEST(Contact, ATentStandsOnTheFloor) {
  const Sheet sheet(cloth_of_grid({21, 21, 0.3, 0.3}, Diagonals::alternating).value(),
                    draping_cloth());
  const std::vector<Obstacle> floor = {Plane{{0.0, 0.0, -0.06}, Eigen::Vector3d::UnitZ()}};
  const Loads loads = weight(sheet.cloth.mesh, kDensity);
  Boundary boundary;
  boundary.held = nodes_where(sheet.cloth.mesh, [](double u, double v) {
    return std::abs(u - 0.15) < 0.016 && std::abs(v - 0.15) < 0.016;
  });
  ASSERT_EQ(boundary.held.size(), 9U);
  State state{shaken(flat(sheet.cloth.mesh), 1e-4, 1), {}};
  for (const int n : boundary.held)
    state.x.segment<3>(3 * n) << sheet.cloth.mesh.material_m.col(n), 0.0;
  EquilibriumOptions options;
  const EquilibriumResult result = solved(sheet, boundary, loads, state, options, floor);
  ASSERT_TRUE(result.is_good(options)) << describe(result, options);
  const Touching touch = touching(sheet, boundary, floor, state, result);
  EXPECT_GT(touch.nodes, 20);
  EXPECT_LT(touch.nodes, 400);
  EXPECT_LE(touch.deepest_m, options.contact_depth_m);
  EXPECT_LE(touch.worst_gap_m, options.contact_depth_m);
  double held_N = 0.0;
  for (const int n : boundary.held) held_N += result.by_node[3 * n + 2];
  const double weight_N = kDensity * 0.09 * 9.81;
  EXPECT_GT(touch.force_N, 0.05 * weight_N);
  EXPECT_NEAR(touch.push.z() + held_N, weight_N, 1e-4 * weight_N);
}

// A strip over a cylinder, both ends hanging down: symmetric, the cylinder bears all of it, and
// above the tangent points the tension is that of a hanging strip.
TEST(Contact, AStripOverACylinder) {
  const double length = 0.3, width = 0.05, radius = 0.03;
  const Sheet sheet(cloth_of_grid({41, 5, length, width}, Diagonals::both).value(),
                    draping_cloth());
  const std::vector<Obstacle> roller = {
      Cylinder{{0.5 * length, 0.0, -radius}, Eigen::Vector3d::UnitY(), radius}};
  const Loads loads = weight(sheet.cloth.mesh, kDensity);
  Boundary boundary;
  boundary.held = {2 * 41 + 20};  // its middle, on the ridge: without friction it would slip
  State state;
  state.x = flat(sheet.cloth.mesh);
  EquilibriumOptions options;
  const EquilibriumResult result = solved(sheet, boundary, loads, state, options, roller);
  ASSERT_TRUE(result.is_good(options)) << describe(result, options);
  const Touching touch = touching(sheet, boundary, roller, state, result);
  EXPECT_LE(touch.deepest_m, options.contact_depth_m);
  EXPECT_LE(touch.worst_gap_m, options.contact_depth_m);
  const double weight_N = kDensity * length * width * 9.81;
  const double held_N = result.by_node[3 * boundary.held[0] + 2];
  EXPECT_NEAR(touch.push.z() + held_N, weight_N, 1e-4 * weight_N);
  EXPECT_NEAR(touch.push.x(), 0.0, 1e-3 * weight_N);
  EXPECT_GT(touch.nodes, 25);
  // the ends hang down by nearly the length that does not lie on the roller
  const double lowest = state.x[2];
  EXPECT_LT(lowest, -radius - 0.5 * (length - M_PI * radius) + 0.012);
  for (int j = 0; j < 5; ++j) {
    const Eigen::Vector3d left = state.x.segment<3>(3 * (41 * j));
    const Eigen::Vector3d right = state.x.segment<3>(3 * (41 * j + 40));
    EXPECT_NEAR(left.x() - 0.5 * length, 0.5 * length - right.x(), 1e-4);
    EXPECT_NEAR(left.z(), right.z(), 1e-4);
  }
}

// The table edge of thesis 3.4.1: nodes above the table are held, the rest hangs over and may not
// enter the table's side.
TEST(Contact, AnOverhangAtATableEdge) {
  const Sheet sheet(cloth_of_grid({25, 9, 0.1, 0.033}, Diagonals::alternating).value(),
                    draping_cloth());
  const double edge = 0.05;
  const Loads loads = weight(sheet.cloth.mesh, kDensity);
  Boundary boundary;
  boundary.held = nodes_where(sheet.cloth.mesh, [&](double u, double) { return u <= edge; });
  // the side of the table, just behind the last held column
  const std::vector<Obstacle> side = {Plane{{edge, 0.0, 0.0}, Eigen::Vector3d::UnitX()}};
  State state{flat(sheet.cloth.mesh), {}};
  EquilibriumOptions options;
  options.tolerance_N = 1e-9;
  const EquilibriumResult result = solved(sheet, boundary, loads, state, options, side);
  ASSERT_TRUE(result.is_good(options)) << describe(result, options);
  EXPECT_LE(touching(sheet, boundary, side, state, result).deepest_m, options.contact_depth_m);
  const double hanging_N = [&] {
    double sum = 0.0;
    for (int n = 0; n < sheet.nodes(); ++n)
      if (sheet.cloth.mesh.material_m(0, n) > edge) sum += loads.node_mass_kg[n] * 9.81;
    return sum;
  }();
  const double on_table_N = loads.node_mass_kg.sum() * 9.81 - hanging_N;
  double held_N = 0.0;
  for (const int n : boundary.held) held_N += result.by_node[3 * n + 2];
  EXPECT_NEAR(held_N, hanging_N + on_table_N, 1e-4 * hanging_N);
  const double drop = state.x[3 * 24 + 2];
  EXPECT_LT(drop, -0.02);
  EXPECT_GT(drop, -0.051);
}

}  // namespace
}  // namespace tenter::mechanics::testing
