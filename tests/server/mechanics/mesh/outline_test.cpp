// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/outline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "server/mechanics/mesh/edges.h"
#include "server/mechanics/mesh/hinges.h"
#include "server/mechanics/mesh/springs.h"
#include "tests/server/mechanics/mesh/random_mesh.h"

namespace tenter::mechanics {
namespace {

using testing::sum;
using testing::tolerance;
using Outline = std::vector<Eigen::Vector2d>;

Outline square(double side) {
  return {{0, 0}, {side, 0}, {side, side}, {0, side}};
}

double mean_edge(const SurfaceMesh& mesh) {
  double total = 0.0;
  int count = 0;
  for (const Edge& edge : edges(mesh)) {
    total += (mesh.material_m.col(edge.high) - mesh.material_m.col(edge.low)).norm();
    ++count;
  }
  return total / count;
}

/// Smallest angle of all triangles, degrees.
double sharpest(const SurfaceMesh& mesh) {
  double smallest = 180.0;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector2d a = mesh.material_m.col(t[(k + 1) % 3]) - mesh.material_m.col(t[k]);
      const Eigen::Vector2d b = mesh.material_m.col(t[(k + 2) % 3]) - mesh.material_m.col(t[k]);
      smallest = std::min(smallest, std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
    }
  return smallest * 57.29577951308232;
}

TEST(Outline, FillsTheSheet) {
  for (const double length : {0.02, 0.01, 0.005, 0.0025}) {
    const auto mesh = triangulate_outline(square(0.1), length);
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_NEAR(sum(triangle_areas_m2(*mesh)), 0.01, tolerance(1e-15));
    EXPECT_NEAR(mean_edge(*mesh) / length, 1.0, 0.15) << length;
    EXPECT_GT(sharpest(*mesh), 20.0) << length;
    // a disc: V - E + T = 1
    EXPECT_EQ(mesh->node_count() - static_cast<int>(edges(*mesh).size()) + mesh->triangle_count(),
              1);
  }
}

/// No direction of the material is preferred: edges spread over the bins, 2 : 1 for the diagonal.
TEST(Outline, IsIrregular) {
  const SurfaceMesh mesh = triangulate_outline(square(0.1), 0.003).value();
  double weft = 0, warp = 0, diagonal = 0;
  for (const Spring& s : mesh_springs(mesh).ring1) {
    weft += s.direction == Direction::weft;
    warp += s.direction == Direction::warp;
    diagonal += s.direction == Direction::diagonal;
  }
  EXPECT_GT(weft + warp + diagonal, 2000);
  EXPECT_NEAR(weft / (weft + warp), 0.5, 0.1);
  EXPECT_NEAR(diagonal / (weft + warp + diagonal), 0.5, 0.1);
}

TEST(Outline, ConcaveOrReversedOrClosed) {
  const Outline letter = {{0, 0}, {0.1, 0}, {0.1, 0.04}, {0.04, 0.04}, {0.04, 0.1}, {0, 0.1}};
  const auto mesh = triangulate_outline(letter, 0.006);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_NEAR(sum(triangle_areas_m2(*mesh)), 0.1 * 0.04 + 0.04 * 0.06, tolerance(1e-15));
  for (const Eigen::Vector2d& corner : letter)
    EXPECT_EQ((mesh->material_m.colwise() - corner).colwise().squaredNorm().minCoeff(), 0.0);
  const auto area = [](const Outline& outline) {
    return sum(triangle_areas_m2(triangulate_outline(outline, 0.006).value()));
  };
  EXPECT_NEAR(area(Outline(letter.rbegin(), letter.rend())), 0.0064, tolerance(1e-15));
  Outline closed = letter;
  closed.push_back(letter.front());
  EXPECT_NEAR(area(closed), 0.0064, tolerance(1e-15));
  const Outline sliver = {{0, 0}, {0.1, 0}, {0.1, 0.02}};  // 11 degrees
  EXPECT_NEAR(area(sliver), 0.001, tolerance(1e-15));
}

TEST(Outline, SameBytesEachTime) {
  const Outline outline = {{0, 0}, {0.1, 0.01}, {0.12, 0.1}, {0.05, 0.07}, {-0.01, 0.1}};
  const SurfaceMesh first = triangulate_outline(outline, 0.004).value();
  std::vector<std::unique_ptr<char[]>> holes;  // other addresses each time
  for (std::size_t round = 1; round < 6; ++round) {
    for (std::size_t k = 0; k < 50; ++k) holes.push_back(std::make_unique<char[]>(round * 577 + k));
    for (std::size_t k = 0; k < holes.size(); k += 3) holes[k].reset();
    const SurfaceMesh again = triangulate_outline(outline, 0.004).value();
    ASSERT_EQ(again.triangles, first.triangles);
    ASSERT_TRUE(again.material_m == first.material_m);
  }
}

TEST(Outline, Errors) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  struct Case {
    Outline outline;
    double length;
    const char* message;
  };
  const Case cases[] = {
      {{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, 0.1, "crosses or touches itself"},
      {{{0, 0}, {1, 0}, {1, 0}, {0, 1}}, 0.1, "crosses or touches itself"},
      {{{0, 0}, {2, 0}, {1, 0}, {1, 1}}, 0.1, "crosses or touches itself"},
      {{{0, 0}, {1, 0}, {2, 0}}, 0.1, "outline"},
      {{{0, 0}, {1, 0}}, 0.1, "2 corners"},
      {{}, 0.1, "0 corners"},
      {{{0, 0}, {1, 0}, {0, nan}}, 0.1, "corner 2 is not finite"},
      {{{0, 0}, {1, 0}, {0, inf}}, 0.1, "corner 2 is not finite"},
      {square(1e-3), 0.1, "too small"},
      {square(1.0), 0.0, "not positive"},
      {square(1.0), -1.0, "not positive"},
      {square(1.0), nan, "not positive"},
      {square(1.0), 1e-6, "more than"},
      {square(1e200), 1.0, "more than"},
      {square(1e-200), 1e-300, "outline"},
      {{{0, 0}, {1, 0}, {1, 1e-9}}, 1e-5, "outline"},
  };
  for (const Case& c : cases) {
    const auto mesh = triangulate_outline(c.outline, c.length);
    ASSERT_FALSE(mesh) << c.message;
    EXPECT_EQ(mesh.error().kind, ErrorKind::bad_input);
    EXPECT_NE(mesh.error().message.find(c.message), std::string::npos) << mesh.error().message;
  }
}

}  // namespace
}  // namespace tenter::mechanics
