// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/springs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "tests/server/mechanics/mesh/random_mesh.h"

namespace tenter::mechanics {
namespace {

using testing::random_mesh;
using testing::tolerance;

constexpr double kDegree = 0.017453292519943295;

Eigen::Vector2d at(double degrees, double length = 1.0) {
  return {length * std::cos(degrees * kDegree), length * std::sin(degrees * kDegree)};
}

TEST(Direction, BinsOf22Point5Degrees) {
  for (const double way : {0.0, 180.0}) {
    for (const double d : {-22.4, -10.0, 0.0, 22.4})
      EXPECT_EQ(direction_of(at(way + d)), Direction::weft) << way + d;
    for (const double d : {67.6, 90.0, 112.4})
      EXPECT_EQ(direction_of(at(way + d, 1e-7)), Direction::warp) << way + d;
    for (const double d : {22.6, 45.0, 67.4, 112.6, 135.0, 157.4})
      EXPECT_EQ(direction_of(at(way + d, 1e7)), Direction::diagonal) << way + d;
  }
  EXPECT_EQ(across(Direction::weft), Direction::warp);
  EXPECT_EQ(across(Direction::warp), Direction::weft);
  EXPECT_EQ(across(Direction::diagonal), Direction::diagonal);
}

/// Turned by 90 degrees weft and warp change places, turned by 45 the axes become diagonals.
TEST(Direction, TurnsWithTheMesh) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const SurfaceMesh mesh = random_mesh(seed, {9, 9, 0.1, 0.1});
    SurfaceMesh quarter = mesh;
    quarter.material_m.row(0) = -mesh.material_m.row(1);
    quarter.material_m.row(1) = mesh.material_m.row(0);
    SurfaceMesh eighth = mesh;
    for (int n = 0; n < mesh.node_count(); ++n)
      eighth.material_m.col(n) =
          (mesh.material_m.col(n) + quarter.material_m.col(n)) / std::sqrt(2.0);
    const Springs a = mesh_springs(mesh);
    const Springs b = mesh_springs(quarter);
    const Springs c = mesh_springs(eighth);
    ASSERT_EQ(a.ring1.size(), b.ring1.size());
    std::map<Direction, int> count;
    for (std::size_t k = 0; k < a.ring1.size(); ++k) {
      ++count[a.ring1[k].direction];
      EXPECT_EQ(b.ring1[k].direction, across(a.ring1[k].direction));
      EXPECT_EQ(c.ring1[k].direction == Direction::diagonal,
                a.ring1[k].direction != Direction::diagonal);
    }
    EXPECT_GT(count[Direction::weft], 20);
    EXPECT_GT(count[Direction::warp], 20);
    EXPECT_GT(count[Direction::diagonal], 20);
  }
}

enum Family { weft, warp, rising, falling };

Family family(const Spring& s) {
  if (s.direction == Direction::weft) return weft;
  if (s.direction == Direction::warp) return warp;
  return s.angle_rad > 0.0 ? rising : falling;
}

std::map<Family, double> areas(const std::vector<Spring>& springs) {
  std::map<Family, double> area;
  for (const Spring& spring : springs) area[family(spring)] += spring.area_m2;
  return area;
}

TEST(Springs, EachFamilySharesOutTheSheet) {
  const Grid grids[] = {{25, 25, 0.1, 0.1}, {7, 12, 0.2, 0.3}, {3, 4, 0.2, 0.3}};
  for (const Grid& grid : grids) {
    const double sheet = grid.length_u_m * grid.length_v_m;
    const Springs regular = grid_springs(grid).value();
    for (const auto& springs : {regular.ring1, regular.ring2}) {
      ASSERT_EQ(areas(springs).size(), 4U);
      for (const auto& [name, area] : areas(springs)) EXPECT_NEAR(area, sheet, tolerance(1e-13));
    }
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Springs irregular = mesh_springs(random_mesh(seed, grid));
      ASSERT_GE(areas(irregular.ring1).size(), 3U);
      for (const auto& springs : {irregular.ring1, irregular.ring2})
        for (const auto& [name, area] : areas(springs)) EXPECT_NEAR(area, sheet, tolerance(1e-13));
    }
  }
}

TEST(Springs, CountsAndLengthsOfTheThesisGrid) {
  const Grid grid{25, 25, 0.096, 0.096};
  const Springs springs = grid_springs(grid).value();
  EXPECT_EQ(springs.ring1.size(), 2U * 24 * 25 + 2 * 24 * 24);
  EXPECT_EQ(springs.ring2.size(), 2U * 23 * 25 + 2 * 23 * 23);
  const SurfaceMesh mesh = grid_mesh(grid, Diagonals::one).value();
  for (const auto& [ring, list] : {std::pair(1, springs.ring1), std::pair(2, springs.ring2)})
    for (const Spring& s : list) {
      const Eigen::Vector2d along = mesh.material_m.col(s.b) - mesh.material_m.col(s.a);
      EXPECT_NEAR(along.norm(), s.rest_length_m, 1e-15);
      EXPECT_EQ(s.direction, direction_of(along));
      const double straight = s.direction == Direction::diagonal ? std::sqrt(2.0) : 1.0;
      EXPECT_NEAR(s.rest_length_m, ring * straight * 0.004, 1e-15);
      EXPECT_NEAR(std::tan(s.angle_rad) * along.x(), along.y(),
                  1e-12 + 1e3 * (s.direction == Direction::warp));
    }
}

/// W = k_u eps_u^2 / 2 + ...: energy of springs under F against area times the density of the
/// material point, whose strains are the stretches of the four directions.
TEST(Springs, HomogeneousStretchHasTheEnergyOfTheMaterialPoint) {
  const double k[] = {120.0, 80.0, 30.0, 17.0};
  testing::Numbers numbers(11);
  const Grid grids[] = {{25, 25, 0.1, 0.1}, {4, 9, 0.03, 0.08}};
  for (const Grid& grid : grids) {
    const SurfaceMesh mesh = grid_mesh(grid, Diagonals::one).value();
    const Springs springs = grid_springs(grid).value();
    for (int state = 0; state < 10; ++state) {
      Eigen::Matrix2d F = Eigen::Matrix2d::Identity();
      for (int e = 0; e < 4; ++e) F(e / 2, e % 2) += numbers.between(-0.2, 0.3);
      const auto strain = [&](const Eigen::Vector2d& a) { return (F * a).norm() / a.norm() - 1.0; };
      const Eigen::Vector2d axes[] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
      double density = 0.0;
      for (int f = 0; f < 4; ++f) density += 0.5 * k[f] * std::pow(strain(axes[f]), 2);
      for (const auto& list : {springs.ring1, springs.ring2}) {
        double energy = 0.0;
        for (const Spring& s : list) {
          const Eigen::Vector2d along = mesh.material_m.col(s.b) - mesh.material_m.col(s.a);
          const double eps = (F * along).norm() / s.rest_length_m - 1.0;
          energy += s.area_m2 * 0.5 * k[family(s)] * eps * eps;
        }
        const double expected = grid.length_u_m * grid.length_v_m * density;
        ASSERT_GT(expected, 1e-6);
        EXPECT_NEAR(energy, expected, tolerance(1e-11 * expected));
      }
    }
  }
}

/// The edges of both splittings of a square grid are the springs of the grid.
TEST(Springs, MeshOfAGridGivesTheSpringsOfTheGrid) {
  const Grid grid{6, 5, 0.5, 0.4};
  std::vector<Spring> expected = grid_springs(grid).value().ring1;
  std::vector<Spring> found = mesh_springs(grid_mesh(grid, Diagonals::both).value()).ring1;
  for (Spring& s : expected)
    if (s.a > s.b) std::swap(s.a, s.b);
  const auto before = [](const Spring& x, const Spring& y) {
    return std::tie(x.a, x.b) < std::tie(y.a, y.b);
  };
  std::sort(expected.begin(), expected.end(), before);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t n = 0; n < found.size(); ++n) {
    EXPECT_EQ(found[n].a, expected[n].a);
    EXPECT_EQ(found[n].b, expected[n].b);
    EXPECT_EQ(family(found[n]), family(expected[n]));
    EXPECT_NEAR(found[n].area_m2, expected[n].area_m2, tolerance(1e-16));
    EXPECT_NEAR(found[n].rest_length_m, expected[n].rest_length_m, tolerance(1e-16));
  }
}

TEST(Springs, GridErrorsComeThrough) {
  EXPECT_FALSE(grid_springs({1, 2, 1.0, 1.0}));
}

}  // namespace
}  // namespace tenter::mechanics
