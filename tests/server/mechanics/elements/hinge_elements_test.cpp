// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <numbers>

#include "server/mechanics/elements/from_mesh.h"
#include "server/mechanics/mesh/grid.h"
#include "tests/server/mechanics/elements/element_checks.h"
#include "tests/server/mechanics/elements/random_energy.h"

namespace tenter::mechanics {
namespace {

Answer evaluate(const HingeElements& hinges, const RandomEnergy& energy, const Eigen::VectorXd& x,
                NodeMatrix* matrix) {
  Answer answer;
  answer.gradient.setZero(x.size());
  for (int first = 0; first < hinges.count(); first += kChunk) {
    const int count = std::min(kChunk, hinges.count() - first);
    double theta[kChunk];
    double psi[kChunk] = {};
    double psi2[kChunk] = {};
    hinge_angles(hinges, x.data(), first, count, theta);
    answer.energy += energy.evaluate(hinges.measure, first, count, theta, psi, psi2);
    add_gradient(hinges, x.data(), first, count, psi, answer.gradient.data());
    if (matrix) add_stiffness(hinges, x.data(), first, count, psi, psi2, *matrix);
  }
  return answer;
}

/// A grid whose nodes are moved by up to `by` in every direction.
Eigen::VectorXd crumpled(const SurfaceMesh& mesh, double by, unsigned seed) {
  testing::Numbers numbers(seed);
  Eigen::VectorXd x(3 * mesh.node_count());
  for (int n = 0; n < mesh.node_count(); ++n) {
    x.segment<2>(3 * n) = mesh.material_m.col(n);
    x[3 * n + 2] = 0.0;
    for (int i = 0; i < 3; ++i) x[3 * n + i] += numbers.between(-by, by);
  }
  return x;
}

void check_hinges(double crumple, double step) {
  const auto mesh = grid_mesh({7, 6, 0.6, 0.5}, Diagonals::alternating);
  ASSERT_TRUE(mesh);
  HingeElements hinges = hinge_elements(mechanics::hinges(*mesh));
  ASSERT_GT(hinges.count(), kChunk);
  NodeMatrix matrix(mesh->node_count(), coupled_nodes(hinges));
  hinges.slots = block_slots(matrix, hinges.nodes);
  const RandomEnergy energy(hinges.count(), 1, 21);
  const Eigen::VectorXd x = crumpled(*mesh, crumple, 22);
  check_derivatives(
      [&](const Eigen::VectorXd& y, NodeMatrix* into) { return evaluate(hinges, energy, y, into); },
      matrix, x, step, 1e-7);
}

TEST(HingeElementsTest, DerivativesNearlyFlat) {
  check_hinges(1e-3, 1e-5);
}
TEST(HingeElementsTest, DerivativesBent) {
  check_hinges(0.02, 1e-5);
}

TEST(HingeElementsTest, TheAngleIsThatOfTheMesh) {
  const auto mesh = grid_mesh({6, 5, 0.5, 0.4}, Diagonals::one);
  ASSERT_TRUE(mesh);
  const std::vector<Hinge> list = mechanics::hinges(*mesh);
  const HingeElements hinges = hinge_elements(list);
  const Eigen::VectorXd x = crumpled(*mesh, 0.03, 5);
  double theta[kChunk];
  const int count = std::min(kChunk, hinges.count());
  hinge_angles(hinges, x.data(), 0, count, theta);
  testing::Comparison angle("angle");
  for (int h = 0; h < count; ++h) {
    const auto& n = list[static_cast<std::size_t>(h)].nodes;
    const auto at = [&](int corner) {
      return Eigen::Vector3d(x.segment<3>(3 * n[static_cast<std::size_t>(corner)]));
    };
    angle.add(theta[h], dihedral_angle(at(0), at(1), at(2), at(3)));
  }
  angle.judge(1e-12, 0.1);
}

// One hinge folded to within a thousandth of closed: still finite, still the derivative.
TEST(HingeElementsTest, NearlyClosed) {
  Hinge hinge{{0, 1, 2, 3}, 1.0, 0.3, 0.3, Direction::weft, 0.0};
  const HingeElements hinges = hinge_elements({hinge});
  for (const double away : {1e-3, -1e-3}) {
    const double fold = std::numbers::pi - std::abs(away);
    const double side = away > 0.0 ? 1.0 : -1.0;
    Eigen::VectorXd x(12);
    x << 0, 0, 0, 1, 0, 0, 0.4, 1, 0, 0.5, -std::cos(fold), -side * std::sin(fold);
    double theta[kChunk];
    hinge_angles(hinges, x.data(), 0, 1, theta);
    EXPECT_NEAR(theta[0], side * fold, 1e-12);
    const double psi[kChunk] = {1.0};
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(12);
    add_gradient(hinges, x.data(), 0, 1, psi, gradient.data());
    for (int i = 0; i < 12; ++i) {
      const auto angle = [&](double value) {
        Eigen::VectorXd y = x;
        y[i] = value;
        double t[kChunk];
        hinge_angles(hinges, y.data(), 0, 1, t);
        return t[0];
      };
      EXPECT_NEAR(gradient[i], testing::difference(angle, x[i], 1e-4), 1e-7);
    }
  }
}

}  // namespace
}  // namespace tenter::mechanics
