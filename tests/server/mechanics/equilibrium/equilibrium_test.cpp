// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/equilibrium.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

model::Model soft_cloth() {
  return preset_with("cloth_stvk", {{"weft", 300.0},
                                    {"warp", 400.0},
                                    {"shear", 60.0},
                                    {"bend_weft", 1e-5},
                                    {"bend_warp", 2e-5},
                                    {"bend_diagonal", 1e-5}});
}

/// A square that hangs by two corners, from its own plane put upright.
struct Curtain {
  explicit Curtain(int side = 11, double length = 0.2)
      : grid{side, side, length, length},
        sheet(cloth_of_grid(grid, Diagonals::alternating).value(), soft_cloth()),
        loads(weight(sheet.cloth.mesh, 0.2)) {
    boundary.held = {grid.node(0, side - 1), grid.node(side - 1, side - 1)};
    state.x =
        placed(sheet.cloth.mesh, [](double u, double v) { return Eigen::Vector3d(u, 0.0, v); });
  }
  EquilibriumResult solve(State& from, const EquilibriumOptions& options = {}) const {
    return solved(sheet, boundary, loads, from, options);
  }
  /// The pins come nearer to each other.
  void close_by(double part) {
    state.x[3 * static_cast<Eigen::Index>(boundary.held[1])] -= part * grid.length_u_m;
  }

  Grid grid;
  Sheet sheet;
  Boundary boundary;
  Loads loads;
  State state;
};

double weight_N(const Loads& loads) {
  return loads.node_mass_kg.sum() * loads.gravity_m_s2.norm();
}

TEST(Equilibrium, FromTheFlatStateToTheToleranceAndToRounding) {
  const Curtain curtain;
  State state = curtain.state, finer = curtain.state;
  EquilibriumOptions options;
  const EquilibriumResult result = curtain.solve(state, options);
  EXPECT_EQ(result.last.end, MinimiseEnd::converged);
  EXPECT_LE(result.last.net_force_N, 1e-5);
  EXPECT_TRUE(result.is_good(options)) << describe(result, options);
  EXPECT_GT((state.x - curtain.state.x).norm(), 1e-3);

  options.tolerance_N = 0.0;
  const EquilibriumResult exact = curtain.solve(finer, options);
  EXPECT_TRUE(exact.is_good(options)) << describe(exact, options);
  EXPECT_LT(exact.last.net_force_N, 1e-11 * weight_N(curtain.loads));
  // at rounding nothing is left to gain by another solve
  State again = finer;
  options.start_is_near = true;
  const EquilibriumResult repeated = curtain.solve(again, options);
  EXPECT_TRUE(repeated.last.is_equilibrium());
  EXPECT_LT((again.x - finer.x).lpNorm<Eigen::Infinity>(), 1e-12);
}

// The energy is a difference of large numbers wherever the origin of heights makes it one.
TEST(Equilibrium, RoundingIsReachedWhereverTheOriginOfHeightsIs) {
  const Curtain curtain;
  State state = curtain.state;
  EquilibriumOptions options;
  options.tolerance_N = 0.0;
  const EquilibriumResult result = curtain.solve(state, options);
  ASSERT_TRUE(result.is_good(options));
  const double to_zero_m = -result.energy_J / weight_N(curtain.loads);
  for (const double height : {to_zero_m, to_zero_m + 1e-9, 10.0, -3000.0}) {
    SCOPED_TRACE(height);
    State shifted = curtain.state;
    for (int n = 0; n < curtain.sheet.nodes(); ++n) shifted.x[3 * n + 2] += height;
    const EquilibriumResult there = curtain.solve(shifted, options);
    EXPECT_TRUE(there.is_good(options)) << describe(there, options);
    // positions carry the rounding of their size
    EXPECT_LT(there.last.net_force_N, (1e-10 + 1e-10 * std::abs(height)) * weight_N(curtain.loads));
  }
}

TEST(Equilibrium, RestIsFoundFromAnywhereNearIt) {
  const Curtain curtain;
  EquilibriumOptions options;
  options.tolerance_N = 0.0;
  for (const unsigned seed : {1U, 2U, 3U}) {
    State state{shaken(flat(curtain.sheet.cloth.mesh), seed == 3 ? 0.0 : 2e-3, seed), {}};
    for (const int n : curtain.boundary.held)
      state.x.segment<3>(3 * n) << curtain.sheet.cloth.mesh.material_m.col(n), 0.0;
    const EquilibriumResult result =
        solved(curtain.sheet, curtain.boundary, Loads{}, state, options);
    EXPECT_TRUE(result.last.is_equilibrium()) << describe(result, options);
    EXPECT_LT(result.last.net_force_N, 1e-10);
    EXPECT_LT(result.energy_J, 1e-15);
  }
}

// A strip that lies exactly in its plane and is pressed together has no force out of it: Newton
// stays in the plane, where the state is a saddle.
TEST(Equilibrium, ExactSaddlesAreLeft) {
  for (const double stiffness : {1e2, 1e4, 1e6}) {
    for (const double shortening : {0.99, 0.8}) {
      SCOPED_TRACE(stiffness);
      SCOPED_TRACE(shortening);
      const Grid grid{17, 5, 0.1, 0.025};
      const Sheet sheet(cloth_of_grid(grid, Diagonals::both).value(),
                        preset_with("cloth_stvk", {{"weft", stiffness},
                                                   {"warp", stiffness},
                                                   {"shear", 0.3 * stiffness},
                                                   {"bend_weft", 1e-6},
                                                   {"bend_warp", 1e-6},
                                                   {"bend_diagonal", 1e-6}}));
      Boundary boundary;
      boundary.held = nodes_where(sheet.cloth.mesh, [](double u, double) {
        return u < 0.01 || u > 0.09;  // two columns: clamped
      });
      State start;
      start.x = placed(sheet.cloth.mesh, [&](double u, double v) {
        const double inner = std::clamp((u - 0.0063) / (0.09375 - 0.0063), 0.0, 1.0);
        return Eigen::Vector3d(u - (1.0 - shortening) * 0.1 * inner, v, 0.0);
      });
      EquilibriumOptions options;
      options.check_minimum = false;
      State in_plane = start;
      const EquilibriumResult saddle = solved(sheet, boundary, Loads{}, in_plane, options);
      ASSERT_TRUE(saddle.last.is_equilibrium()) << describe(saddle, options);
      double out_of_plane = 0.0;
      for (int n = 0; n < sheet.nodes(); ++n)
        out_of_plane = std::max(out_of_plane, std::abs(in_plane.x[3 * n + 2]));
      EXPECT_EQ(out_of_plane, 0.0);

      options.check_minimum = true;
      State state = start;
      const EquilibriumResult result = solved(sheet, boundary, Loads{}, state, options);
      EXPECT_TRUE(result.is_good(options)) << describe(result, options);
      EXPECT_EQ(result.stability, Stability::minimum);
      EXPECT_GE(result.saddles_left, 1);
      EXPECT_LT(result.energy_J, 0.9 * saddle.energy_J);
      double height = 0.0;
      for (int n = 0; n < sheet.nodes(); ++n)
        height = std::max(height, std::abs(state.x[3 * n + 2]));
      EXPECT_GT(height, 0.03 * 0.1);
    }
  }
}

TEST(Equilibrium, UnsupportedMeshesSayTheyAre) {
  const Curtain curtain;
  // falls
  for (const Minimiser minimiser :
       {Minimiser::newton, Minimiser::additive_lm, Minimiser::relaxation}) {
    State state = curtain.state;
    EquilibriumOptions options;
    options.minimiser = minimiser;
    const EquilibriumResult falls =
        solved(curtain.sheet, Boundary{}, curtain.loads, state, options);
    EXPECT_FALSE(falls.is_good(options));
    EXPECT_FALSE(describe(falls, options).empty());
    EXPECT_TRUE(state.x.allFinite() && falls.by_node.allFinite());
    EXPECT_TRUE(std::isfinite(falls.energy_J) && std::isfinite(falls.last.net_force_N));
  }
  // floats: in equilibrium, and nothing holds it
  for (const unsigned seed : {0U, 1U, 2U}) {
    State state{shaken(curtain.state.x, seed == 0 ? 0.0 : 1e-3, seed), {}};
    EquilibriumOptions options;
    options.tolerance_N = 1e-9;
    const EquilibriumResult floats = solved(curtain.sheet, Boundary{}, Loads{}, state, options);
    EXPECT_TRUE(floats.last.is_equilibrium()) << describe(floats, options);
    EXPECT_EQ(floats.stability, Stability::neutral);
    EXPECT_TRUE(state.x.allFinite());
  }
  // swings about one node
  Boundary one_pin;
  one_pin.held = {curtain.boundary.held[0]};
  State state = curtain.state;
  EquilibriumOptions options;
  const EquilibriumResult swings = solved(curtain.sheet, one_pin, curtain.loads, state, options);
  EXPECT_TRUE(swings.is_good(options)) << describe(swings, options);
  EXPECT_EQ(swings.stability, Stability::neutral) << "it may turn about the vertical";
}

TEST(Equilibrium, ACollapsedStartIsNoNumber) {
  const Curtain curtain;
  for (const Minimiser minimiser :
       {Minimiser::newton, Minimiser::additive_lm, Minimiser::relaxation}) {
    State state{Eigen::VectorXd::Zero(curtain.state.x.size()), {}};
    EquilibriumOptions options;
    options.minimiser = minimiser;
    const EquilibriumResult result = curtain.solve(state, options);
    EXPECT_EQ(result.last.end, MinimiseEnd::start_not_finite);
    EXPECT_FALSE(result.is_good(options));
    EXPECT_FALSE(std::isnan(result.energy_J));
    EXPECT_FALSE(std::isnan(result.last.net_force_N));
    EXPECT_TRUE(result.by_node.allFinite());
    EXPECT_TRUE(state.x.allFinite());
  }
}

TEST(Equilibrium, MinimisersAgreeWhereTheStateIsUnique) {
  // taut: the pins are pulled apart, and a strip along the lower edge is held as well
  Curtain curtain(9);
  const int side = curtain.grid.nodes_u;
  for (int i = 0; i < side; ++i) {
    curtain.boundary.held.push_back(curtain.grid.node(i, 0));
    if (i > 0 && i < side - 1) curtain.boundary.held.push_back(curtain.grid.node(i, side - 1));
  }
  for (int i = 0; i < side; ++i) curtain.state.x[3 * curtain.grid.node(i, side - 1) + 2] += 0.02;
  EquilibriumOptions options;
  options.tolerance_N = 1e-9;
  options.max_iterations = 200000;
  State newton = curtain.state;
  const EquilibriumResult reference = curtain.solve(newton, options);
  ASSERT_TRUE(reference.is_good(options));
  ASSERT_GT((newton.x - curtain.state.x).norm(), 1e-3);
  for (const Minimiser minimiser : {Minimiser::additive_lm, Minimiser::relaxation}) {
    options.minimiser = minimiser;
    State other = curtain.state;
    const EquilibriumResult result = curtain.solve(other, options);
    EXPECT_TRUE(result.is_good(options)) << describe(result, options);
    EXPECT_LT((other.x - newton.x).lpNorm<Eigen::Infinity>(), 1e-8);
    EXPECT_NEAR(result.energy_J, reference.energy_J, 1e-10 * std::abs(reference.energy_J));
    EXPECT_GE(result.iterations, reference.iterations);
  }
}

TEST(Equilibrium, TheSameBytesRunAfterRunAndInThreads) {
  // a path of frames with its own solver: bytes of all states
  const auto frames = [](double part) {
    Curtain curtain;
    auto solver = EquilibriumSolver::make(curtain.sheet.model, curtain.boundary).value();
    std::vector<double> bytes;
    State state = curtain.state;
    for (int frame = 0; frame < 5; ++frame) {
      EquilibriumOptions options;
      options.start_is_near = frame > 0;
      const auto result =
          solver.solve(curtain.sheet.parameters, curtain.loads, state, options).value();
      bytes.insert(bytes.end(), state.x.begin(), state.x.end());
      bytes.push_back(result.energy_J);
      bytes.push_back(result.iterations);
      state.x[3 * static_cast<Eigen::Index>(curtain.boundary.held[1])] -= part * 0.2;
    }
    return bytes;
  };
  const std::vector<double> first = frames(0.02), second = frames(0.03);
  ASSERT_NE(first, second);
  EXPECT_EQ(frames(0.02), first);
  for (int round = 0; round < 3; ++round) {
    std::vector<double> a, b;
    std::thread one([&] { a = frames(0.02); });
    std::thread two([&] { b = frames(0.03); });
    one.join();
    two.join();
    EXPECT_EQ(a, first);
    EXPECT_EQ(b, second);
  }
}

TEST(Equilibrium, PredictionLeadsWhereAColdStartDoes) {
  Curtain curtain;
  curtain.close_by(-0.01);  // taut between the pins
  EquilibriumOptions options;
  options.tolerance_N = 1e-10;
  auto solver = EquilibriumSolver::make(curtain.sheet.model, curtain.boundary).value();
  State warm = curtain.state;
  ASSERT_TRUE(solver.solve(curtain.sheet.parameters, curtain.loads, warm, options)
                  .value()
                  .is_good(options));
  options.start_is_near = true;
  Eigen::VectorXd parameters = curtain.sheet.parameters;
  int warm_iterations = 0, cold_iterations = 0;
  for (int frame = 0; frame < 4; ++frame) {
    parameters *= 1.01;
    Loads loads = curtain.loads;
    loads.gravity_m_s2.x() = 0.05 * frame;
    warm.x[3 * static_cast<Eigen::Index>(curtain.boundary.held[1])] += 2e-4;
    curtain.close_by(-0.001);
    options.start_is_near = true;
    const auto result = solver.solve(parameters, loads, warm, options).value();
    ASSERT_TRUE(result.is_good(options)) << describe(result, options);
    warm_iterations += result.iterations;

    auto fresh = EquilibriumSolver::make(curtain.sheet.model, curtain.boundary).value();
    State cold = curtain.state;
    options.start_is_near = false;
    const auto reference = fresh.solve(parameters, loads, cold, options).value();
    ASSERT_TRUE(reference.is_good(options)) << describe(reference, options);
    cold_iterations += reference.iterations;
    EXPECT_LT((warm.x - cold.x).lpNorm<Eigen::Infinity>(), 1e-9);
  }
  EXPECT_LT(2 * warm_iterations, cold_iterations);
}

}  // namespace
}  // namespace tenter::mechanics::testing
