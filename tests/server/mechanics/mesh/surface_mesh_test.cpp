// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/surface_mesh.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

#include "server/mechanics/mesh/edges.h"
#include "server/mechanics/mesh/grid.h"
#include "tests/server/mechanics/mesh/random_mesh.h"

namespace tenter::mechanics {
namespace {

using testing::random_mesh;
using testing::sum;
using testing::tolerance;

constexpr Grid kThesis{25, 25, 0.1, 0.1};
constexpr Diagonals kSplittings[] = {Diagonals::one, Diagonals::alternating, Diagonals::other,
                                     Diagonals::both};

TEST(SurfaceMesh, AreasAndMassesSumToTheWhole) {
  const Grid grid{9, 14, 0.3, 0.5};
  const double area = grid.length_u_m * grid.length_v_m;
  std::vector<SurfaceMesh> meshes;
  for (const Diagonals splitting : kSplittings)
    meshes.push_back(grid_mesh(grid, splitting).value());
  for (unsigned seed = 1; seed <= 20; ++seed) meshes.push_back(random_mesh(seed, grid));
  for (const SurfaceMesh& mesh : meshes) {
    EXPECT_NEAR(sum(triangle_areas_m2(mesh)), area, tolerance(1e-13 * area));
    EXPECT_NEAR(sum(lumped_masses_kg(mesh, 0.187)), 0.187 * area, tolerance(1e-13 * area));
    const std::vector<double> weighed = lumped_masses_of_total_kg(mesh, 1.73e-3);
    EXPECT_NEAR(sum(weighed), 1.73e-3, tolerance(1e-16));
    for (const double mass : weighed) EXPECT_GT(mass, 0.0);
  }
}

/// A third of each triangle to each corner leaves the centre of mass where it is.
TEST(SurfaceMesh, MassesKeepTheCentreOfMass) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const SurfaceMesh mesh = random_mesh(seed, {8, 6, 0.2, 0.1});
    const std::vector<double> mass = lumped_masses_kg(mesh, 2.0);
    const Eigen::Map<const Eigen::VectorXd> m(mass.data(), mesh.node_count());
    const Eigen::Vector2d centre = mesh.material_m * m / m.sum();
    EXPECT_NEAR(centre.x(), 0.1, tolerance(1e-15));
    EXPECT_NEAR(centre.y(), 0.05, tolerance(1e-15));
  }
}

TEST(SurfaceMesh, SplittingsOfTheThesisGrid) {
  for (const Diagonals splitting : kSplittings) {
    const SurfaceMesh mesh = grid_mesh(kThesis, splitting).value();
    const std::size_t layers = splitting == Diagonals::both ? 2 : 1;
    EXPECT_EQ(mesh.node_count(), 625);
    EXPECT_EQ(mesh.triangles.size(), layers * 2 * 24 * 24);
    EXPECT_EQ(edges(mesh).size(), layers * (2 * 24 * 25 + 24 * 24));
  }
  // one: every diagonal rises; alternating: half of them
  const auto rising = [](const SurfaceMesh& mesh) {
    int count = 0;
    for (const Edge& edge : edges(mesh)) {
      const Eigen::Vector2d along = mesh.material_m.col(edge.high) - mesh.material_m.col(edge.low);
      if (std::abs(along.x()) > 1e-9 && std::abs(along.y()) > 1e-9)
        count += along.x() * along.y() > 0.0 ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(rising(grid_mesh(kThesis, Diagonals::one).value()), 576);
  EXPECT_EQ(rising(grid_mesh(kThesis, Diagonals::alternating).value()), 288);
  EXPECT_EQ(rising(grid_mesh(kThesis, Diagonals::other).value()), 0);
  EXPECT_EQ(rising(grid_mesh(kThesis, Diagonals::both).value()), 576);
}

/// Reflected in u, `both` is itself: same masses, corner by corner.
TEST(SurfaceMesh, BothDiagonalsHaveTheSymmetryOfTheGrid) {
  const Grid grid{5, 4, 0.4, 0.3};
  const std::vector<double> both = lumped_masses_kg(grid_mesh(grid, Diagonals::both).value(), 1.0);
  const std::vector<double> one = lumped_masses_kg(grid_mesh(grid, Diagonals::one).value(), 1.0);
  const std::size_t left = 0;
  const std::size_t right = 4;
  EXPECT_NEAR(both[left], both[right], 1e-18);
  EXPECT_NEAR(both[left], 0.25 * 0.01, 1e-17);
  EXPECT_GT(std::abs(one[left] - one[right]), 1e-3);
}

TEST(SurfaceMesh, EdgesKnowTheirSides) {
  const SurfaceMesh mesh = random_mesh(7, {6, 7, 0.5, 0.6});
  int boundary = 0;
  for (const Edge& edge : edges(mesh)) {
    boundary += edge.interior() ? 0 : 1;
    const Eigen::Vector2d along = mesh.material_m.col(edge.high) - mesh.material_m.col(edge.low);
    const auto side = [&](int corner) {
      const Eigen::Vector2d to = mesh.material_m.col(corner) - mesh.material_m.col(edge.low);
      return along.x() * to.y() - along.y() * to.x();
    };
    if (edge.left_corner >= 0) {
      EXPECT_GT(side(edge.left_corner), 0.0);
    }
    if (edge.right_corner >= 0) {
      EXPECT_LT(side(edge.right_corner), 0.0);
    }
  }
  EXPECT_EQ(boundary, 2 * 5 + 2 * 6);
}

struct Broken {
  const char* what;
  const char* message;  ///< a part of it
  SurfaceMesh mesh;
};

SurfaceMesh square() {
  return grid_mesh({2, 2, 1.0, 1.0}, Diagonals::one).value();
}

std::vector<Broken> broken_meshes() {
  std::vector<Broken> cases;
  const auto add = [&](const char* what, const char* message, auto change) {
    SurfaceMesh mesh = square();
    change(mesh);
    cases.push_back({what, message, mesh});
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  add("no triangles", "no triangles", [](SurfaceMesh& m) { m.triangles.clear(); });
  add("index too large", "triangle 1 (nodes 0, 4, 2)", [](SurfaceMesh& m) {
    m.triangles[1] = {0, 4, 2};
  });
  add("negative index", "triangle 0 (nodes 0, -1, 3)", [](SurfaceMesh& m) {
    m.triangles[0] = {0, -1, 3};
  });
  add("node twice", "uses a node twice", [](SurfaceMesh& m) { m.triangles[0] = {0, 0, 3}; });
  add("flipped", "triangle 1 (nodes 3, 0, 2) is flipped", [](SurfaceMesh& m) {
    m.triangles[1] = {3, 0, 2};
  });
  add("not a number", "node 2 is not finite", [&](SurfaceMesh& m) { m.material_m(1, 2) = nan; });
  add("overflow", "degenerate", [](SurfaceMesh& m) { m.material_m *= 1e200; });
  add("flat", "triangle 0 (nodes 0, 1, 3) is degenerate",
      [](SurfaceMesh& m) { m.material_m.col(1) << 0.5, 0.5 - 1e-8; });
  add("third triangle", "edge of nodes 0 and 3 has triangles 1 and 2", [](SurfaceMesh& m) {
    m.material_m.conservativeResize(2, 5);
    m.material_m.col(4) << 0.1, 0.9;
    m.triangles.push_back({0, 3, 4});
  });
  add("unused node", "node 4 belongs to no triangle", [](SurfaceMesh& m) {
    m.material_m.conservativeResize(2, 5);
    m.material_m.col(4) << 2.0, 2.0;
  });
  add("weights", "1 weights for 2 triangles", [](SurfaceMesh& m) { m.triangle_weight = {1.0}; });
  add("negative weight", "is not positive", [](SurfaceMesh& m) {
    m.triangle_weight = {1.0, -1.0};
  });
  add("layers", "3 layers for 2", [](SurfaceMesh& m) { m.triangle_layer = {0, 0, 0}; });
  return cases;
}

TEST(SurfaceMesh, ErrorsNameTheElement) {
  ASSERT_TRUE(check(square()));
  for (const Broken& broken : broken_meshes()) {
    const Expected<void> checked = check(broken.mesh);
    ASSERT_FALSE(checked) << broken.what;
    EXPECT_EQ(checked.error().kind, ErrorKind::bad_input) << broken.what;
    EXPECT_NE(checked.error().message.find(broken.message), std::string::npos)
        << broken.what << ": " << checked.error().message;
  }
}

TEST(Grid, RefusesWhatIsNoGrid) {
  EXPECT_FALSE(grid_mesh({1, 5, 1.0, 1.0}, Diagonals::one));
  EXPECT_FALSE(grid_mesh({5, -5, 1.0, 1.0}, Diagonals::one));
  EXPECT_FALSE(grid_mesh({5, 5, 0.0, 1.0}, Diagonals::one));
  EXPECT_FALSE(grid_mesh({5, 5, 1.0, std::numeric_limits<double>::infinity()}, Diagonals::one));
  EXPECT_FALSE(grid_mesh({2000000000, 2000000000, 1.0, 1.0}, Diagonals::one));
  EXPECT_FALSE(grid_mesh({3, 3, 1.0, 1e-9}, Diagonals::one));
  const Grid grid{4, 3, 0.3, 0.4};
  const SurfaceMesh mesh = grid_mesh(grid, Diagonals::one).value();
  EXPECT_EQ(mesh.material_m.col(grid.node(3, 2)), Eigen::Vector2d(0.3, 0.4));
  EXPECT_EQ(mesh.material_m.col(4), Eigen::Vector2d(0.0, 0.2));
}

}  // namespace
}  // namespace tenter::mechanics
