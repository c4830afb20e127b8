// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/hinges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "server/mechanics/mesh/edges.h"
#include "tests/server/mechanics/mesh/random_mesh.h"

namespace tenter::mechanics {
namespace {

using testing::random_mesh;
using testing::sum;
using testing::tolerance;

/// The sheet rolled on a cylinder of radius R about an axis along v.
Eigen::Matrix3Xd rolled(const SurfaceMesh& mesh, double radius) {
  Eigen::Matrix3Xd x(3, mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    const double phi = mesh.material_m(0, n) / radius;
    x.col(n) << radius * std::sin(phi), mesh.material_m(1, n), radius * std::cos(phi);
  }
  return x;
}

TEST(Hinges, OneForEachInteriorEdge) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Grid grid{11, 6, 0.2, 0.1};
    const SurfaceMesh mesh = random_mesh(seed, grid);
    int interior = 0;
    for (const Edge& edge : edges(mesh)) interior += edge.interior() ? 1 : 0;
    // Euler: E = N + T - 1 for a disc; all but the rim are interior
    EXPECT_EQ(interior, mesh.node_count() + mesh.triangle_count() - 1 - 2 * (10 + 5));
    const std::vector<Hinge> found = hinges(mesh);
    ASSERT_EQ(static_cast<int>(found.size()), interior);
    for (const Hinge& h : found) {
      EXPECT_LT(h.nodes[0], h.nodes[1]);
      EXPECT_EQ(h.rest_angle_rad, 0.0);
      EXPECT_NEAR(h.area_m2, h.rest_length_m * h.height_m, 1e-18);
    }
  }
}

/// A third of each triangle to each of its sides; what goes to the rim is missing.
TEST(Hinges, AreasAreAThirdOfTheTrianglesBeside) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const SurfaceMesh mesh = random_mesh(seed, {11, 6, 0.2, 0.1});
    const std::vector<double> area = triangle_areas_m2(mesh);
    double rim = 0.0;
    for (const Edge& edge : edges(mesh))
      if (!edge.interior())
        rim +=
            area[static_cast<std::size_t>(std::max(edge.left_triangle, edge.right_triangle))] / 3;
    double total = 0.0;
    for (const Hinge& h : hinges(mesh)) total += h.area_m2;
    ASSERT_GT(rim, 1e-4);
    EXPECT_NEAR(total + rim, sum(area), tolerance(1e-15));
  }
}

TEST(Hinges, RightTriangleByHand) {
  // two triangles over the edge of length 4 mm, heights 3 and 6 mm: h0 = (3 + 6) / 6
  Eigen::Matrix2Xd nodes(2, 4);
  nodes << 0.0, 4e-3, 1e-3, 2e-3, 0.0, 0.0, 3e-3, -6e-3;
  const SurfaceMesh mesh = make_surface_mesh(nodes, {{0, 1, 2}, {1, 0, 3}}).value();
  const std::vector<Hinge> found = hinges(mesh);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].nodes, (std::array<int, 4>{0, 1, 2, 3}));
  EXPECT_DOUBLE_EQ(found[0].rest_length_m, 4e-3);
  EXPECT_DOUBLE_EQ(found[0].height_m, 1.5e-3);
  EXPECT_DOUBLE_EQ(found[0].area_m2, 6e-6);
  EXPECT_EQ(found[0].bend, Direction::warp);  // the edge runs along the weft
}

TEST(Hinges, BothDiagonalsAreTheMeanOfTheTwo) {
  const Grid grid{5, 4, 0.1, 0.1};
  std::map<Direction, double> both, one, other;
  for (const Hinge& h : hinges(grid_mesh(grid, Diagonals::both).value())) both[h.bend] += h.area_m2;
  for (const Hinge& h : hinges(grid_mesh(grid, Diagonals::one).value())) one[h.bend] += h.area_m2;
  for (const Hinge& h : hinges(grid_mesh(grid, Diagonals::other).value()))
    other[h.bend] += h.area_m2;
  for (const auto& [bend, area] : both) {
    ASSERT_GT(area, 1e-4);
    EXPECT_NEAR(area, 0.5 * (one[bend] + other[bend]), tolerance(1e-17));
  }
  EXPECT_EQ(both.size(), 3U);
}

TEST(Hinges, AngleHasTheSignOfTheRidge) {
  const Eigen::Vector3d from(0, 0, 0), to(1, 0, 0), left(0.3, 1, 0);
  for (const double angle : {-3.0, -1.5, -1e-8, 0.0, 1e-8, 0.7, 3.0}) {
    // the right corner turned down by the angle, the normals pointing up: a ridge
    const Eigen::Vector3d right(0.6, -2 * std::cos(angle), -2 * std::sin(angle));
    EXPECT_NEAR(dihedral_angle(from, to, left, right), angle, 1e-14);
    // seen from the other end of the edge it is the same hinge
    EXPECT_NEAR(dihedral_angle(to, from, right, left), angle, 1e-14);
  }
  EXPECT_EQ(dihedral_angle(from, from, left, left), 0.0);
  EXPECT_EQ(dihedral_angle(from, to, to, left), 0.0);
}

/// Rolled on a cylinder, hinges along its axis have eps = 3 / R and stand for a third of the sheet.
TEST(Hinges, RestAnglesOfARolledSheet) {
  const Grid grid{33, 9, 0.2, 0.1};
  const double radius = 0.05;
  const SurfaceMesh mesh = grid_mesh(grid, Diagonals::one).value();
  const auto found = hinges(mesh, rolled(mesh, radius));
  ASSERT_TRUE(found) << found.error().message;
  int along_axis = 0;
  for (const Hinge& h : *found) {
    if (h.bend == Direction::warp) {
      EXPECT_NEAR(h.rest_angle_rad, 0.0, 1e-12);
    }
    if (h.bend != Direction::weft) continue;
    ++along_axis;
    EXPECT_NEAR(h.rest_angle_rad / h.height_m, 3.0 / radius, 3.0 / radius * 1e-12);
  }
  EXPECT_EQ(along_axis, 31 * 8);
}

TEST(Hinges, RestShapeErrors) {
  const SurfaceMesh mesh = grid_mesh({3, 3, 0.1, 0.1}, Diagonals::one).value();
  EXPECT_FALSE(hinges(mesh, Eigen::Matrix3Xd::Zero(3, 8)));
  const auto point = hinges(mesh, Eigen::Matrix3Xd::Zero(3, 9));
  ASSERT_FALSE(point);
  EXPECT_NE(point.error().message.find("has no area"), std::string::npos);
  Eigen::Matrix3Xd broken = rolled(mesh, 0.1);
  broken(0, 4) = std::nan("");
  EXPECT_FALSE(hinges(mesh, broken));
}

}  // namespace
}  // namespace tenter::mechanics
