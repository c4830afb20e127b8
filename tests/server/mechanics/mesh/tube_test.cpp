// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/tube.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

#include "server/mechanics/mesh/hinges.h"
#include "server/mechanics/mesh/springs.h"

namespace tenter::mechanics {
namespace {

constexpr Tube kTube{12, 7, 0.05, 0.18};

/// The seam is a place like any other: as many of everything in every column.
TEST(TubeMesh, HasNoSeamToBeSeen) {
  for (const auto diagonals : {Diagonals::one, Diagonals::alternating, Diagonals::both}) {
    const auto mesh = tube_mesh(kTube, diagonals);
    ASSERT_TRUE(mesh) << mesh.error().message;
    const double around = 2.0 * std::numbers::pi * kTube.radius_m;
    const std::vector<double> area = triangle_areas_m2(*mesh);
    EXPECT_NEAR(std::accumulate(area.begin(), area.end(), 0.0), around * kTube.length_m, 1e-15);
    const std::vector<double> mass = lumped_masses_kg(*mesh, 0.2);
    const std::size_t step = diagonals == Diagonals::alternating ? 2 : 1;
    for (std::size_t n = step; n < 12; n += step) EXPECT_NEAR(mass[n], mass[0], 1e-15);
    // rings of 12 edges, 12 edges along and 12 diagonals a row; those of the two rims do not bend
    const std::size_t layers = diagonals == Diagonals::both ? 2 : 1;
    const std::vector<Hinge> bends = hinges(*mesh);
    EXPECT_EQ(bends.size(), layers * 12U * (5U + 6U + 6U));
    for (const Hinge& hinge : bends) EXPECT_LT(hinge.rest_length_m, 0.05);
    for (const Spring& spring : mesh_springs(*mesh).ring1) EXPECT_LT(spring.rest_length_m, 0.05);
  }
}

TEST(TubeMesh, RollsUpWithoutStretchAndBendsOneWay) {
  const auto mesh = tube_mesh({200, 4, 0.05, 0.005}, Diagonals::alternating);
  ASSERT_TRUE(mesh) << mesh.error().message;
  const Eigen::Matrix3Xd round_m = rolled_m(*mesh);
  double longest = 0.0;
  for (const Hinge& hinge : hinges(*mesh)) {
    const Eigen::Vector3d a = round_m.col(hinge.nodes[0]), b = round_m.col(hinge.nodes[1]);
    EXPECT_NEAR((b - a).norm(), hinge.rest_length_m, 1e-4 * hinge.rest_length_m);
    longest = std::max(longest, hinge.rest_length_m);
    if (hinge.bend != Direction::weft) continue;
    const double angle =
        dihedral_angle(a, b, round_m.col(hinge.nodes[2]), round_m.col(hinge.nodes[3]));
    EXPECT_NEAR(angle / (3.0 * hinge.height_m), 1.0 / 0.05,
                0.01);  // a ridge: normals point outwards
  }
  EXPECT_GT(longest, 0.0015);
}

TEST(TubeMesh, RefusesWhatIsNone) {
  EXPECT_FALSE(tube_mesh({3, 4, 0.05, 0.1}, Diagonals::one));
  EXPECT_FALSE(tube_mesh({8, 1, 0.05, 0.1}, Diagonals::one));
  EXPECT_FALSE(tube_mesh({9, 4, 0.05, 0.1}, Diagonals::alternating));
  EXPECT_TRUE(tube_mesh({9, 4, 0.05, 0.1}, Diagonals::one));
  EXPECT_FALSE(tube_mesh({8, 4, 0.0, 0.1}, Diagonals::one));
  EXPECT_FALSE(tube_mesh({8, 4, 0.05, -0.1}, Diagonals::one));
  auto mesh = tube_mesh({8, 4, 0.05, 0.1}, Diagonals::one);
  ASSERT_TRUE(mesh);
  mesh->period_u_m *= 0.37;  // edges go a third of the way around
  EXPECT_FALSE(check(*mesh));
}

}  // namespace
}  // namespace tenter::mechanics
