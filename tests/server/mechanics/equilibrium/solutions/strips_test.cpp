// SPDX-License-Identifier: GPL-3.0-or-later
// Strips: pulled by a clip, hanging, and the heavy elastica.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/server/mechanics/equilibrium/sheets.h"

namespace tenter::mechanics::testing {
namespace {

/// Stretch at which St. Venant-Kirchhoff k carries the nominal tension, k s (s^2 - 1)/2.
double stretch_under(double tension_N_m, double k) {
  double s = 1.0;
  for (int i = 0; i < 60; ++i)
    s -= (0.5 * k * s * (s * s - 1.0) - tension_N_m) / (0.5 * k * (3.0 * s * s - 1.0));
  return s;
}

// A load, not a displacement, is given: the bar goes where the closed form says, on any mesh.
TEST(Strips, AClipIsPulledAsFarAsTheClosedFormSays) {
  const double k = 60.0, length = 0.1, width = 0.04, pull_N = 0.9;
  for (const int side : {3, 6, 12}) {
    const Grid grid{2 * side, side, length, width};
    const Sheet sheet(cloth_of_grid(grid, Diagonals::both).value(),
                      linear_model({{"green_u", k}, {"green_v", k}, {"green_uv", 20.0}}));
    State state{flat(sheet.cloth.mesh), {Pose{}}};
    Boundary boundary;
    boundary.held = nodes_where(sheet.cloth.mesh, [](double u, double) { return u == 0.0; });
    Clip bar = clip_on(
        "bar", nodes_where(sheet.cloth.mesh, [&](double u, double) { return u > length - 1e-9; }),
        state.x, Pose{});
    bar.is_free = true;
    bar.cord_place_m = {{length + 0.01, 0.0, 0.0}, {length + 0.01, width, 0.0}};
    boundary.clips = {bar};
    Loads loads;
    loads.cord_force_N = {{{0.5 * pull_N, 0.0, 0.0}, {0.5 * pull_N, 0.0, 0.0}}};
    EquilibriumOptions options;
    options.tolerance_N = 1e-11;
    const EquilibriumResult result = solved(sheet, boundary, loads, state, options);
    ASSERT_TRUE(result.is_good(options)) << describe(result, options);
    const double stretch = stretch_under(pull_N / width, k);
    ASSERT_GT(stretch, 1.2);
    for (int n = 0; n < sheet.nodes(); ++n) {
      EXPECT_NEAR(state.x[3 * n], stretch * sheet.cloth.mesh.material_m(0, n), 1e-10);
      EXPECT_NEAR(state.x[3 * n + 1], sheet.cloth.mesh.material_m(1, n), 1e-10);
    }
  }
}

// Tension w (L - s): a row of triangles carries what hangs below its middle, exactly, so that the
// length is a midpoint rule of the integral of the stretch: second order.
TEST(Strips, AHangingStripCarriesWhatHangsBelow) {
  const double k = 8.0, length = 0.5, width = 0.05, density = 0.3;
  const double w = density * 9.81;
  // Gauss would do; Simpson on 2000 pieces is exact to rounding here
  double exact = 0.0;
  const int pieces = 2000;
  for (int i = 0; i <= pieces; ++i) {
    const double s = length * i / pieces;
    const double weight = i == 0 || i == pieces ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    exact += weight * stretch_under(w * (length - s), k) * length / (3.0 * pieces);
  }
  ASSERT_GT(exact, 1.05 * length);
  std::vector<double> errors;
  for (const int rows : {5, 10, 20, 40}) {
    const Sheet sheet(cloth_of_grid({3, rows + 1, width, length}, Diagonals::both).value(),
                      linear_model({{"green_u", k}, {"green_v", k}, {"green_uv", 3.0}}));
    State state;
    state.x =
        placed(sheet.cloth.mesh, [](double u, double v) { return Eigen::Vector3d(u, 0.0, -v); });
    Boundary boundary;
    boundary.held = {0, 1, 2};
    EquilibriumOptions options;
    options.tolerance_N = 1e-12;
    const EquilibriumResult result =
        solved(sheet, boundary, weight(sheet.cloth.mesh, density), state, options);
    ASSERT_TRUE(result.is_good(options)) << describe(result, options);
    for (int row = 0; row < rows; ++row) {
      const double stretch = (state.x[9 * row + 2] - state.x[9 * (row + 1) + 2]) / (length / rows);
      const double tension = 0.5 * k * stretch * (stretch * stretch - 1.0);
      EXPECT_NEAR(tension, w * (length - (row + 0.5) * length / rows), 1e-9 * w * length);
    }
    errors.push_back(std::abs(-state.x[9 * rows + 2] - exact) / exact);
    EXPECT_NEAR(result.by_node[2] + result.by_node[5] + result.by_node[8], w * length * width,
                1e-9 * w * length * width);
  }
  for (std::size_t i = 1; i < errors.size(); ++i) {
    const double observed = order(errors[i - 1], errors[i]);
    std::printf("hanging strip, %2d rows: error %.2e, order %.2f\n", 5 << i, errors[i], observed);
    EXPECT_NEAR(observed, 2.0, 0.1);
  }
}

/// Place of the free end of the heavy elastica EI theta'' = -w (L - s) cos theta, theta(0) = 0,
/// theta'(L) = 0: right of and below the clamp. Shooting for theta'(0), Runge and Kutta's rule.
Eigen::Vector2d elastica_end(double bending_N_m, double w_N_m2, double length) {
  constexpr int kSteps = 4000;
  const double h = length / kSteps;
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  // whether theta' falls below zero before the end or theta passes the vertical: of larger or
  // smaller curvatures one or the other comes first
  const auto bends_back = [&](double curvature) {
    double theta = 0.0, slope = curvature;
    end.setZero();
    const auto second = [&](double s, double t) {
      return -w_N_m2 * (length - s) * std::cos(t) / bending_N_m;
    };
    for (int i = 0; i < kSteps; ++i) {
      const double s = i * h;
      const double k1 = slope, l1 = second(s, theta);
      const double k2 = slope + 0.5 * h * l1, l2 = second(s + 0.5 * h, theta + 0.5 * h * k1);
      const double k3 = slope + 0.5 * h * l2, l3 = second(s + 0.5 * h, theta + 0.5 * h * k2);
      const double k4 = slope + h * l3, l4 = second(s + h, theta + h * k3);
      const double t1 = theta, t2 = theta + 0.5 * h * k2, t4 = theta + h * k3;
      theta += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
      slope += h * (l1 + 2.0 * l2 + 2.0 * l3 + l4) / 6.0;
      const Eigen::Vector2d mean(std::cos(t1) + 4.0 * std::cos(t2) + std::cos(t4),
                                 std::sin(t1) + 4.0 * std::sin(t2) + std::sin(t4));
      end += h * mean / 6.0;
      if (slope < 0.0) return true;
      if (theta > 0.5 * M_PI) return false;
    }
    return false;
  };
  double low = 0.0, high = w_N_m2 * length * length / bending_N_m;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (bends_back(middle) ? low : high) = middle;
  }
  bends_back(high);
  return end;
}

// eps_b is 3 curvatures, on hinges that stand for a third of the sheet: psi = (k/2) 9 kappa^2 / 3,
// so a strip bends as a beam of EI = 3 k a width. Hinges lie on the columns of the grid, each for
// half a cell to both sides; with two columns held the clamp is half way between them. Then all is
// central: second order. The membrane is so stiff that its stretch (w L / k) does not count. Both
// diagonals: with one of them, or alternating ones, bending couples to twist
// (bending_bias_test.cpp) and a strip that is free to twist bends as a softer one.
TEST(Strips, TheHeavyElastica) {
  const double density = 0.2, length = 0.1, w = density * 9.81;
  struct Case {
    const char* name;
    double k;  ///< of bending, N m
  };
  for (const Case& c : {Case{"stiff", 1.5e-4}, Case{"medium", 3e-5}, Case{"limp", 3e-6}}) {
    const Eigen::Vector2d exact = elastica_end(3.0 * c.k, w, length);
    EXPECT_GT(exact.y(), 0.1 * length);
    std::vector<double> errors;
    for (const int cells : {10, 20, 40, 80}) {
      const double cell = length / (cells + 0.5);
      const Grid grid{cells + 2, 3, length + 0.5 * cell, 2.0 * cell};
      const Sheet sheet(cloth_of_grid(grid, Diagonals::both).value(),
                        linear_model({{"green_u", 3e4},
                                      {"green_v", 3e4},
                                      {"green_uv", 1e4},
                                      {"bend_u", c.k},
                                      {"bend_v", c.k},
                                      {"bend_d", c.k}}));
      Boundary boundary;
      boundary.held =
          nodes_where(sheet.cloth.mesh, [&](double u, double) { return u < 1.5 * cell; });
      State state{flat(sheet.cloth.mesh), {}};
      EquilibriumOptions options;
      options.tolerance_N = 1e-9;
      const EquilibriumResult result =
          solved(sheet, boundary, weight(sheet.cloth.mesh, density), state, options);
      ASSERT_TRUE(result.is_good(options)) << describe(result, options);
      const Eigen::Vector3d tip = state.x.segment<3>(3 * grid.node(cells + 1, 1));
      errors.push_back((Eigen::Vector2d(tip.x() - 0.5 * cell, -tip.z()) - exact).norm() / length);
    }
    for (std::size_t i = 1; i < errors.size(); ++i) {
      const double observed = order(errors[i - 1], errors[i]);
      std::printf("heavy elastica, %-6s %2d cells: error %.2e, order %.2f\n", c.name, 10 << i,
                  errors[i], observed);
      EXPECT_NEAR(observed, 2.0, 0.25);
    }
    EXPECT_LT(errors.back(), 5e-4);
  }
}

}  // namespace
}  // namespace tenter::mechanics::testing
