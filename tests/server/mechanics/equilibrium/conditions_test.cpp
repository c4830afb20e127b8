// SPDX-License-Identifier: GPL-3.0-or-later
// What boundary conditions and loads refuse, and that what they do to a body balances.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "common/base/not_a_number.h"
#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

model::Model plain_cloth() {
  return preset_with("cloth_stvk", {{"bend_weft", 1e-4}, {"bend_warp", 1e-4}});
}

/// A clip on the free edge of a square: nodes 20 to 24 of 5 x 5, cords at its corners.
struct Hanging {
  Hanging()
      : sheet(cloth_of_grid({5, 5, 0.1, 0.1}, Diagonals::alternating).value(), plain_cloth()) {
    state.x = placed(sheet.cloth.mesh, [](double u, double v) {
      return Eigen::Vector3d(u, 0.01 * u, -v);  // hangs down
    });
    boundary.held = {0, 1, 2};
    boundary.clips = {clip_on("bar", {20, 21, 22, 23, 24}, state.x, pose),
                      clip_on("stand", {4}, state.x, pose)};
    Clip& bar = boundary.clips[0];
    bar.is_free = true;
    bar.mass_kg = 0.004;
    bar.centre_of_mass_m = {0.055, 0.0, -0.103};
    bar.cord_place_m = {{0.0, 0.005, -0.11}, {0.1, -0.005, -0.11}};
    state.clips = {pose, pose};
    loads = weight(sheet.cloth.mesh, 0.2);
    loads.cord_force_N = {{{-0.05, 0.1, -0.3}, {0.1, -0.02, -0.35}}, {}};
    loads.node_force_N = Eigen::VectorXd::Zero(3 * sheet.nodes());
    loads.node_force_N.segment<3>(3 * 12) << 0.02, 0.03, 0.01;
  }

  /// The sentence that make() or solve() refuses with; empty if they don't.
  std::string refusal() const {
    auto solver = EquilibriumSolver::make(sheet.model, boundary, obstacles);
    if (!solver) return solver.error().message;
    State start = state;
    auto result =
        solver->solve(parameters.size() ? parameters : sheet.parameters, loads, start, options);
    return result ? "" : result.error().message;
  }

  Pose pose;
  Sheet sheet;
  Boundary boundary;
  std::vector<Obstacle> obstacles;
  State state;
  Loads loads;
  Eigen::VectorXd parameters;
  EquilibriumOptions options;
};

TEST(Conditions, WhatDoesNotFitIsRefusedWithItsName) {
  struct Case {
    const char* sentence;
    void (*spoil)(Hanging&);
  };
  const Case cases[] = {
      {"held already",
       [](Hanging& h) {
         h.boundary.held = {0, 0};
       }},
      {"holds node 25, of which there are 25", [](Hanging& h) { h.boundary.held = {25}; }},
      {"holds node -1", [](Hanging& h) { h.boundary.held = {-1}; }},
      {"clip \"bar\" holds node 0, which is held",
       [](Hanging& h) { h.boundary.clips[0].nodes[2] = 0; }},
      {"clip \"bar\" holds no node",
       [](Hanging& h) {
         h.boundary.clips[0].nodes.clear();
         h.boundary.clips[0].place_m.clear();
       }},
      {"has 4 places for 5 nodes", [](Hanging& h) { h.boundary.clips[0].place_m.pop_back(); }},
      {"a place that is no number", [](Hanging& h) { h.boundary.clips[0].place_m[1].y() = kNaN; }},
      {"a place that is no number",
       [](Hanging& h) { h.boundary.clips[0].cord_place_m[1].y() = kNaN; }},
      {"no proper mass", [](Hanging& h) { h.boundary.clips[0].mass_kg = -1.0; }},
      {"no proper mass", [](Hanging& h) { h.boundary.clips[0].mass_kg = kNaN; }},
      {"lie on one line",
       [](Hanging& h) {
         Clip& bar = h.boundary.clips[0];
         bar.mass_kg = 0.0;
         bar.cord_place_m = {bar.place_m[1], 0.3 * bar.place_m[0] + 0.7 * bar.place_m[4]};
       }},
      {"lie on one line", [](Hanging& h) { h.boundary.clips[1].is_free = true; }},
      {"the pressed surface has node 25",
       [](Hanging& h) {
         h.boundary.pressed = {{0, 1, 25}};
       }},
      {"an edge from node 0 to 24, which no element has",
       [](Hanging& h) {
         h.boundary.pressed = {{0, 24, 6}};
       }},
      {"nothing is free",
       [](Hanging& h) {
         h.boundary.clips.clear();
         h.state.clips.clear();
         h.boundary.held.resize(25);
         for (int n = 0; n < 25; ++n) h.boundary.held[static_cast<std::size_t>(n)] = n;
       }},
      {"normal must be of length one",
       [](Hanging& h) {
         h.obstacles = {Plane{{0, 0, 0}, {0, 0, 2}}};
       }},
      {"normal must be of length one",
       [](Hanging& h) {
         h.obstacles = {Plane{{0, kNaN, 0}, {0, 0, 1}}};
       }},
      {"axis must be of length one",
       [](Hanging& h) {
         h.obstacles = {Cylinder{{0, 0, 0}, {0, kNaN, 1}, 0.1}};
       }},
      {"radius must be positive",
       [](Hanging& h) {
         h.obstacles = {Cylinder{{0, 0, 0}, {1, 0, 0}, 0.0}};
       }},
      {"the model has 6 parameters, given are 5",
       [](Hanging& h) { h.parameters = Eigen::VectorXd::Ones(5); }},
      {"a parameter is no number",
       [](Hanging& h) { h.parameters = Eigen::VectorXd::Constant(6, kNaN); }},
      {"the mesh has 25 nodes, positions are given for 24",
       [](Hanging& h) { h.state.x.conservativeResize(72); }},
      {"a position is no number", [](Hanging& h) { h.state.x[40] = kNaN; }},
      {"there are 2 clips, poses are given for 1", [](Hanging& h) { h.state.clips.pop_back(); }},
      {"pose of clip \"stand\"", [](Hanging& h) { h.state.clips[1].position_m.x() = kNaN; }},
      {"pose of clip \"stand\"", [](Hanging& h) { h.state.clips[1].rotation(1, 1) = kNaN; }},
      {"pose of clip \"bar\"", [](Hanging& h) { h.state.clips[0].rotation *= 1.1; }},
      {"pose of clip \"bar\"", [](Hanging& h) { h.state.clips[0].rotation *= -1.0; }},
      {"gravity is no number", [](Hanging& h) { h.loads.gravity_m_s2.x() = kNaN; }},
      {"the masses must be", [](Hanging& h) { h.loads.node_mass_kg[3] = kNaN; }},
      {"the masses must be", [](Hanging& h) { h.loads.node_mass_kg[3] = -1e-9; }},
      {"the masses must be", [](Hanging& h) { h.loads.node_mass_kg.conservativeResize(3); }},
      {"the forces on nodes", [](Hanging& h) { h.loads.node_force_N.conservativeResize(25); }},
      {"the forces on nodes", [](Hanging& h) { h.loads.node_force_N[3] = kNaN; }},
      {"given for 1 clips", [](Hanging& h) { h.loads.cord_force_N.pop_back(); }},
      {"has 2 cords and forces for 1", [](Hanging& h) { h.loads.cord_force_N[0].pop_back(); }},
      {"a cord force of clip \"bar\"", [](Hanging& h) { h.loads.cord_force_N[0][1].z() = kNaN; }},
      {"the pressure is no number", [](Hanging& h) { h.loads.pressure_Pa = kNaN; }},
      {"tolerance_N", [](Hanging& h) { h.options.tolerance_N = kNaN; }},
      {"tolerance_N", [](Hanging& h) { h.options.tolerance_N = -1e-5; }},
      {"max_iterations", [](Hanging& h) { h.options.max_iterations = -1; }},
      {"max_move_m", [](Hanging& h) { h.options.max_move_m = kNaN; }},
      {"contact_depth_m", [](Hanging& h) { h.options.contact_depth_m = kNaN; }},
      {"contact_depth_m", [](Hanging& h) { h.options.contact_depth_m = 0.0; }},
      {"limit_tolerance", [](Hanging& h) { h.options.limit_tolerance = -1.0; }},
      {"contact_penalty_N_m", [](Hanging& h) { h.options.contact_penalty_N_m = kNaN; }},
  };
  EXPECT_EQ(Hanging().refusal(), "");
  for (const Case& c : cases) {
    Hanging hanging;
    c.spoil(hanging);
    const std::string said = hanging.refusal();
    EXPECT_NE(said.find(c.sentence), std::string::npos)
        << "wanted: " << c.sentence << "\nsaid: " << said;
  }
}

/// Force and torque about the origin.
struct Total {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  double size = 0.0;

  void add(const Eigen::Vector3d& f, const Eigen::Vector3d& at) {
    force += f;
    torque += at.cross(f);
    size += f.norm();
  }
  void add(const Wrench& wrench) {
    force += wrench.force_N;
    torque += wrench.torque_N_m;
  }
};

// All loads against all reactions, of a body with held nodes, a prescribed and a free clip, a force
// on a node, gravity and an obstacle; the free clip's own balance on the way.
TEST(Conditions, LoadsAndReactionsBalance) {
  Hanging h;
  h.obstacles = {Cylinder{{0.05, -0.012, -0.05}, Eigen::Vector3d::UnitX(), 0.02}};
  auto solver = EquilibriumSolver::make(h.sheet.model, h.boundary, h.obstacles);
  ASSERT_TRUE(solver) << solver.error().message;
  EquilibriumOptions options;
  options.tolerance_N = 1e-9;
  options.contact_depth_m = 1e-8;
  State state = h.state;
  const auto result = solver->solve(h.sheet.parameters, h.loads, state, options);
  ASSERT_TRUE(result);
  ASSERT_TRUE(result->is_good(options)) << describe(*result, options);

  const Eigen::Vector3d origin(0.3, -0.2, 0.1);
  Total total;
  for (int n = 0; n < h.sheet.nodes(); ++n) {
    const Eigen::Vector3d at = state.x.segment<3>(3 * n) - origin;
    total.add(h.loads.node_mass_kg[n] * h.loads.gravity_m_s2, at);
    total.add(h.loads.node_force_N.segment<3>(3 * n), at);
  }
  const std::vector<int>& free = solver->unknowns().free_nodes();
  double pressed_N = 0.0;
  for (std::size_t k = 0; k < free.size(); ++k) {
    const Eigen::Vector3d at = state.x.segment<3>(3 * free[k]);
    const double force = result->contact_force_N[static_cast<Eigen::Index>(k)];
    EXPECT_GE(force, 0.0);
    pressed_N += force;
    const Gap g = gap(h.obstacles[0], at);
    EXPECT_GT(g.value_m, -1e-8);
    EXPECT_TRUE(force == 0.0 || g.value_m < 1e-8);
    total.add(force * g.normal, at - origin);
    EXPECT_LT(result->by_node.segment<3>(3 * free[k]).norm(), 1e-9);
  }
  EXPECT_GT(pressed_N, 0.02);
  const double loads_N = total.size;
  for (const int n : h.boundary.held)
    total.add(result->by_node.segment<3>(3 * n), state.x.segment<3>(3 * n) - origin);
  const Wrench stand =
      reaction(h.boundary.clips[1], state.x, result->by_node, origin);  // the cloth pulls at it
  total.force -= stand.force_N;
  total.torque -= stand.torque_N_m;
  const Wrench outer = outer_wrench(h.loads, h.boundary, 0, state.clips[0], origin);
  total.add(outer);
  EXPECT_GT(loads_N, 0.05);
  EXPECT_LT(total.force.norm(), 1e-8);
  EXPECT_LT(total.torque.norm(), 1e-8);

  const Wrench inner = reaction(h.boundary.clips[0], state.x, result->by_node, origin);
  EXPECT_GT(inner.force_N.norm(), 0.1);
  EXPECT_LT((inner.force_N + outer.force_N).norm(), 1e-9);
  EXPECT_LT((inner.torque_N_m + outer.torque_N_m).norm(), 1e-9);
}

// Bodies stay rigid, and poses are those of the nodes, whatever the parity of iterations.
TEST(Conditions, PosesAgreeWithNodes) {
  for (const int iterations : {0, 1, 2, 3, 50}) {
    Hanging h;
    const Pose tilted{rotation_of({0.3, -0.2, 0.5}), {0.03, 0.02, -0.01}};
    h.boundary.clips[1] = clip_on("stand", {4}, h.state.x, tilted);
    h.state.clips[1] = tilted;
    EquilibriumOptions options;
    options.max_iterations = iterations;
    State state = h.state;
    const EquilibriumResult result = solved(h.sheet, h.boundary, h.loads, state, options);
    EXPECT_EQ(result.last.is_equilibrium(), iterations == 50);
    EXPECT_EQ(state.clips[1].position_m, tilted.position_m);
    EXPECT_EQ(state.clips[1].rotation, tilted.rotation);
    EXPECT_EQ((state.x.segment<3>(3 * 24) - h.state.x.segment<3>(3 * 24)).norm() > 1e-4,
              iterations > 0);
    State again = state;
    place_clips(h.boundary, again);
    EXPECT_EQ(again.x, state.x);
  }
}

// A cord pulls at a bar on the end of a strip that does not resist bending: the strip becomes
// straight and the bar turns until the line of the pull runs along it.
TEST(Conditions, AFreeClipTurnsIntoItsPull) {
  const Sheet sheet(cloth_of_grid({2, 6, 0.01, 0.05}, Diagonals::both).value(),
                    linear_model({{"green_u", 2000.0}, {"green_v", 2000.0}, {"green_uv", 500.0}}));
  Boundary boundary;
  State state{flat(sheet.cloth.mesh), {Pose{}}};
  boundary.held = {0, 1};
  Clip bar = clip_on("bar", {10, 11}, state.x, Pose{});
  bar.is_free = true;
  bar.cord_place_m = {{0.005, 0.08, 0.01}};
  boundary.clips = {bar};
  Loads loads;
  const Eigen::Vector3d pull(0.0, 1.5, 0.9);
  loads.cord_force_N = {{pull}};
  EquilibriumOptions options;
  options.tolerance_N = 1e-9;
  const EquilibriumResult result = solved(sheet, boundary, loads, state, options);
  ASSERT_TRUE(result.last.is_equilibrium()) << describe(result, options);
  const Eigen::Vector3d middle(0.005, 0.0, 0.0);
  const Eigen::Vector3d end = state.clips[0].to_space(bar.cord_place_m[0]);
  EXPECT_GT((end - bar.cord_place_m[0]).norm(), 0.01);
  EXPECT_LT((end - middle).cross(pull.normalized()).norm(), 1e-8 * (end - middle).norm());
  for (int n = 2; n < 10; ++n) {
    const Eigen::Vector3d at = state.x.segment<3>(3 * n) - middle;
    EXPECT_NEAR(std::abs(at.cross(pull.normalized()).x()), 0.0, 1e-8);
  }
}

}  // namespace
}  // namespace tenter::mechanics::testing
