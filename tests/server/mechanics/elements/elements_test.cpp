// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "server/mechanics/elements/from_mesh.h"
#include "server/mechanics/mesh/grid.h"
#include "tests/server/mechanics/elements/element_checks.h"
#include "tests/server/mechanics/elements/random_energy.h"

namespace tenter::mechanics {
namespace {

/// The sum over all chunks; the stiffness goes into `matrix` where one is given.
template <class Elements>
Answer evaluate(const Elements& elements, const RandomEnergy& energy, const Eigen::VectorXd& x,
                NodeMatrix* matrix) {
  constexpr int kZ = Elements::kEntries;
  Answer answer;
  answer.gradient.setZero(x.size());
  for (int first = 0; first < elements.count(); first += kChunk) {
    const int count = std::min(kChunk, elements.count() - first);
    double z[kZ * kChunk];
    double psi_z[kZ * kChunk] = {};
    double psi_zz[c_entries(kZ) * kChunk] = {};
    cauchy_green(elements, x.data(), first, count, z);
    answer.energy += energy.evaluate(elements.measure, first, count, z, psi_z, psi_zz);
    add_gradient(elements, x.data(), first, count, psi_z, answer.gradient.data());
    if (matrix) add_stiffness(elements, x.data(), first, count, psi_z, psi_zz, *matrix);
  }
  return answer;
}

Eigen::VectorXd shaken(const Eigen::Matrix3Xd& rest, double by, unsigned seed) {
  testing::Numbers numbers(seed);
  Eigen::VectorXd x(rest.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = rest.data()[i] + numbers.between(-by, by);
  return x;
}

/// Gradient and stiffness of some nodes against differences, and no net force.
template <class Elements>
void check_elements(Elements elements, const Eigen::VectorXd& x, double spacing) {
  ASSERT_GT(elements.count(), kChunk) << "more than one chunk";
  ASSERT_NE(elements.count() % kLanes, 0) << "lanes that stay empty";
  const int nodes = static_cast<int>(x.size() / 3);
  NodeMatrix matrix(nodes, coupled_nodes(elements));
  elements.slots = block_slots(matrix, elements.nodes);
  const RandomEnergy energy(elements.count(), Elements::kEntries, 11);
  const Answer answer =
      check_derivatives([&](const Eigen::VectorXd& y,
                            NodeMatrix* into) { return evaluate(elements, energy, y, into); },
                        matrix, x, 1e-3 * spacing, 1e-8);

  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int n = 0; n < nodes; ++n) {
    const Eigen::Vector3d f = answer.gradient.segment<3>(3 * n);
    force += f;
    moment += Eigen::Vector3d(x.segment<3>(3 * n)).cross(f);
  }
  const double scale = answer.gradient.cwiseAbs().maxCoeff();
  EXPECT_LT(force.norm(), 1e-11 * scale);
  EXPECT_LT(moment.norm(), 1e-11 * scale * x.cwiseAbs().maxCoeff());
}

Eigen::Matrix3Xd in_space(const Eigen::Matrix2Xd& flat) {
  Eigen::Matrix3Xd space = Eigen::Matrix3Xd::Zero(3, flat.cols());
  space.topRows(2) = flat;
  return space;
}

TEST(ElementsTest, Edges) {
  const Grid grid{7, 6, 0.6, 0.5};
  const auto mesh = grid_mesh(grid, Diagonals::alternating);
  const auto springs = grid_springs(grid);
  ASSERT_TRUE(mesh && springs);
  check_elements(edge_elements(springs->ring1), shaken(in_space(mesh->material_m), 0.03, 1), 0.1);
}

TEST(ElementsTest, Triangles) {
  const auto mesh = grid_mesh({8, 6, 0.7, 0.5}, Diagonals::alternating);
  ASSERT_TRUE(mesh);
  check_elements(triangle_elements(*mesh), shaken(in_space(mesh->material_m), 0.03, 2), 0.1);
}

TEST(ElementsTest, Tetrahedra) {
  const auto mesh = box_tetrahedra(3, 3, 2, {0.3, 0.3, 0.2});
  ASSERT_TRUE(mesh);
  check_elements(tetrahedron_elements(*mesh), shaken(mesh->rest_m, 0.02, 3), 0.1);
}

TEST(ElementsTest, HexahedronPoints) {
  auto mesh = box_hexahedra(3, 3, 1, {0.3, 0.3, 0.1});
  ASSERT_TRUE(mesh);
  HexahedronPoints points = hexahedron_points(*mesh);
  ASSERT_EQ(points.count(), 72);
  // lanes that stay empty: one point less
  HexahedronPoints fewer;
  for (int e = 0; e < 71; ++e) {
    std::array<std::array<double, 3>, 8> gradients;
    for (int a = 0; a < 8; ++a)
      for (int i = 0; i < 3; ++i)
        gradients[static_cast<std::size_t>(a)][static_cast<std::size_t>(i)] =
            points.shape[static_cast<std::size_t>((a * 3 + i) * points.padded() + e)];
    fewer.add(points.nodes[static_cast<std::size_t>(e)], gradients,
              points.measure[static_cast<std::size_t>(e)]);
  }
  fewer.finish();
  check_elements(fewer, shaken(mesh->rest_m, 0.02, 4), 0.1);
}

// F of a homogeneous deformation comes back exactly, on every kind of element.
TEST(ElementsTest, AHomogeneousDeformationIsSeenAsItIs) {
  Eigen::Matrix3d f;
  f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, -0.2, 0.1, 1.2;
  const Eigen::Matrix3d c = f.transpose() * f;
  const double solid[6] = {c(0, 0), c(1, 1), c(2, 2), c(1, 2), c(0, 2), c(0, 1)};
  const double sheet[3] = {c(0, 0), c(1, 1), c(0, 1)};
  const auto compare = [](const auto& elements, const Eigen::Matrix3Xd& x, const double* oracle) {
    constexpr int kZ = std::decay_t<decltype(elements)>::kEntries;
    double z[kZ * kChunk];
    const int count = std::min(kChunk, elements.count());
    ASSERT_GT(count, 0);
    cauchy_green(elements, x.data(), 0, count, z);
    for (int k = 0; k < kZ; ++k)
      for (int e = 0; e < count; ++e) EXPECT_NEAR(z[k * kChunk + e], oracle[k], 1e-13);
  };
  const auto mesh = grid_mesh({4, 4, 0.3, 0.3}, Diagonals::one);
  const auto tetrahedra = box_tetrahedra(2, 2, 2, {0.2, 0.2, 0.2});
  const auto hexahedra = box_hexahedra(2, 2, 2, {0.2, 0.2, 0.2});
  ASSERT_TRUE(mesh && tetrahedra && hexahedra);
  compare(triangle_elements(*mesh), f * in_space(mesh->material_m), sheet);
  compare(tetrahedron_elements(*tetrahedra), f * tetrahedra->rest_m, solid);
  compare(hexahedron_points(*hexahedra), f * hexahedra->rest_m, solid);
}

TEST(ElementsTest, NoElementsAreNone) {
  EXPECT_EQ(edge_elements({}).count(), 0);
  EXPECT_EQ(hinge_elements({}).count(), 0);
  EXPECT_EQ(tetrahedron_elements(SolidMesh{}).padded(), 0);
}

}  // namespace
}  // namespace tenter::mechanics
