// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/grid_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "server/mechanics/mesh/hinges.h"
#include "server/mechanics/mesh/springs.h"

namespace tenter::mechanics {
namespace {

// unlike spacings, off the origin
const GridLines kUnlike{{0.01, 0.02, 0.026, 0.03, 0.05}, {-0.02, -0.01, 0.0, 0.004, 0.02, 0.03}};
constexpr double kArea_m2 = 0.04 * 0.05;

TEST(GridLines, FollowThePowerAwayFromOnePlace) {
  const auto lines = graded_lines({.hi_m = 0.2, .cells = 8, .towards_m = {0.0}, .beta = 2.5});
  ASSERT_TRUE(lines);
  ASSERT_EQ(lines->size(), 9U);
  for (int k = 0; k <= 8; ++k)
    EXPECT_NEAR((*lines)[static_cast<std::size_t>(k)], 0.2 * std::pow(k / 8.0, 2.5), 1e-15) << k;
  const auto equal = graded_lines({.lo_m = 1.0, .hi_m = 2.0, .cells = 4, .beta = 3.0});
  for (int k = 0; k <= 4; ++k)
    EXPECT_NEAR((*equal)[static_cast<std::size_t>(k)], 1.0 + 0.25 * k, 1e-15);
}

TEST(GridLines, PassThroughGivenPlacesAndAreAlikeWhereTheseAre) {
  const LineGrading frame{.hi_m = 0.12,
                          .cells = 23,
                          .through_m = {0.01, 0.11, 0.02, 0.1},
                          .towards_m = {0.02, 0.01, 0.1, 0.11},
                          .beta = 2.2};
  const auto lines = graded_lines(frame).value();
  ASSERT_EQ(lines.size(), 24U);
  for (const double place : frame.through_m)
    EXPECT_EQ(std::count(lines.begin(), lines.end(), place), 1) << place;
  double smallest = 1.0, largest = 0.0;
  for (std::size_t k = 0; k + 1 < lines.size(); ++k) {
    const double cell = lines[k + 1] - lines[k];
    ASSERT_GT(cell, 0.0);
    smallest = std::min(smallest, cell);
    largest = std::max(largest, cell);
    EXPECT_NEAR(lines[k] + lines[lines.size() - 1 - k], 0.12, 1e-15);
  }
  EXPECT_GT(largest, 8.0 * smallest);
  // what is rigid gets one
  LineGrading strip{.hi_m = 1.0, .cells = 6, .through_m = {0.5}, .one_cell_at_m = {0.2}};
  EXPECT_EQ(graded_lines(strip).value(), (std::vector<double>{0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}));
}

TEST(GridLines, RefuseWhatCannotBe) {
  const auto complaint = [](const LineGrading& grading) {
    const auto lines = graded_lines(grading);
    return lines ? std::string() : lines.error().message;
  };
  EXPECT_EQ(complaint({}), "grid lines: length 0.000000 m is not positive");
  EXPECT_EQ(complaint({.hi_m = 1.0, .beta = 0.5}), "grid lines: beta 0.500000 is below 1");
  EXPECT_EQ(complaint({.hi_m = 1.0, .towards_m = {2.0}}), "grid lines: 2.000000 m lies outside");
  EXPECT_EQ(complaint({.hi_m = 1.0, .through_m = {-1.0}}), "grid lines: a line lies outside");
  EXPECT_EQ(complaint({.hi_m = 1.0, .cells = 9, .through_m = {0.5, 0.5}}),
            "grid lines: two at 0.500000 m");
  EXPECT_EQ(complaint({.hi_m = 1.0, .cells = 2, .through_m = {0.2, 0.5}}),
            "grid lines: 2 cells for 3 stretches");
  EXPECT_FALSE(check(GridLines{{0.0, 1.0}, {0.0}}));
  EXPECT_FALSE(check(GridLines{{0.0, 1.0}, {0.0, 2.0, 1.0}}));
}

TEST(GridLines, EqualOnesAreTheGrid) {
  const Grid grid{6, 4, 0.5, 0.4};
  const SurfaceMesh a = grid_mesh(grid, Diagonals::both).value();
  const SurfaceMesh b = grid_mesh(lines_of(grid), Diagonals::both).value();
  EXPECT_EQ(a.material_m, b.material_m);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST(GridLines, AreasAndFamiliesOfSpringsSumToTheSheet) {
  for (const Diagonals diagonals : {Diagonals::one, Diagonals::alternating, Diagonals::both}) {
    const auto areas = triangle_areas_m2(grid_mesh(kUnlike, diagonals).value());
    EXPECT_NEAR(std::accumulate(areas.begin(), areas.end(), 0.0), kArea_m2, 1e-16);
  }
  const Springs springs = grid_springs(kUnlike).value();
  for (const auto* ring : {&springs.ring1, &springs.ring2}) {
    std::map<std::pair<Direction, bool>, double> total;
    for (const Spring& s : *ring)
      total[{s.direction, s.direction == Direction::diagonal && s.angle_rad > 0.0}] += s.area_m2;
    ASSERT_EQ(total.size(), 4U);
    for (const auto& [family, area] : total) EXPECT_NEAR(area, kArea_m2, 1e-16);
  }
}

/// Rolled about a line of the grid, hinges along that line have eps = 3 / R and stand for a third
/// of what lies between the middles of the outermost cells, whatever the spacings.
TEST(GridLines, HingesMeasureABendAlongTheLines) {
  const double radius = 0.2;
  for (const bool along_u : {true, false}) {
    const SurfaceMesh mesh = grid_mesh(kUnlike, Diagonals::both).value();
    Eigen::Matrix3Xd rolled(3, mesh.node_count());
    for (int n = 0; n < mesh.node_count(); ++n) {
      const double s = mesh.material_m(along_u ? 0 : 1, n);
      const double t = mesh.material_m(along_u ? 1 : 0, n);
      const Eigen::Vector3d at(radius * std::sin(s / radius), t,
                               radius * (1.0 - std::cos(s / radius)));
      rolled.col(n) << at[along_u ? 0 : 1], at[along_u ? 1 : 0], at[2];
    }
    double area = 0.0;
    int checked = 0;
    const std::vector<Hinge> found = hinges(mesh, rolled).value();
    for (const Hinge& h : found) {
      const Eigen::Vector2d edge =
          mesh.material_m.col(h.nodes[1]) - mesh.material_m.col(h.nodes[0]);
      const double eps = std::abs(h.rest_angle_rad) / h.height_m;
      if (std::abs(edge[along_u ? 0 : 1]) > 1e-12) {
        EXPECT_NEAR(eps, 0.0, 1e-9);
        continue;
      }
      EXPECT_NEAR(eps * radius, 3.0, 0.02);  // chords for arcs
      area += h.area_m2;
      ++checked;
    }
    const auto& s = along_u ? kUnlike.u_m : kUnlike.v_m;
    const auto& t = along_u ? kUnlike.v_m : kUnlike.u_m;
    const double between = 0.5 * (s.back() + s[s.size() - 2] - s[1] - s[0]);
    EXPECT_NEAR(area, between * (t.back() - t.front()) / 3.0, 1e-15);
    EXPECT_GT(checked, 20);
  }
}

}  // namespace
}  // namespace tenter::mechanics
