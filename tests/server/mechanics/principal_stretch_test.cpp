// SPDX-License-Identifier: GPL-3.0-or-later
// Terms of principal stretches where two or all of them are equal, or nearly: the Hessian against
// differences of the gradient, which is smooth there.
#include "server/mechanics/principal_stretch.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/server/mechanics/differences.h"
#include "tests/server/mechanics/point_energy.h"
#include "tests/server/mechanics/random_solids.h"

namespace tenter::mechanics {
namespace {

using testing::Comparison;
using testing::difference;
using testing::energy_at;
using testing::model_of;
using testing::Numbers;
using testing::random_rotation;
using testing::z_of;

const double kGaps[] = {0.0,  1e-16, 1e-13, 1e-10, 1e-8, 1e-7, 1e-6, 3e-6,
                        4e-6, 5e-6,  6e-6,  1e-5,  1e-4, 1e-3, 1e-2};

template <int N>
void compare(const model::Model& model, const Eigen::Matrix<double, N, 1>& z, double gap) {
  Comparison hessian("Hessian at a gap of " + std::to_string(gap));
  const auto at = energy_at<N>(model, z);
  EXPECT_NEAR((at.by_zz - at.by_zz.transpose()).norm(), 0.0, 1e-12 * at.by_zz.norm());
  for (int k = 0; k < N; ++k) {
    const Eigen::Matrix<double, N, 1> column = difference(
        [&](double x) -> Eigen::Matrix<double, N, 1> {
          Eigen::Matrix<double, N, 1> moved = z;
          moved[k] = x;
          return energy_at<N>(model, moved).by_z;
        },
        z[k], 3e-4);
    for (int l = 0; l < N; ++l) hessian.add(at.by_zz(l, k), column[l]);
  }
  hessian.judge(1e-8, 1.0);
}

model::Model solid_model() {
  return model_of({{"solid_principal_stretches", "ogden", {70.0, 3.7}},
                   {"solid_principal_stretches", "linear", {40.0}}});
}
model::Model membrane_model() {
  return model_of(
      {{"principal_stretches", "ogden", {70.0, 3.7}}, {"principal_stretches", "bilinear", {40.0}}});
}

TEST(PrincipalStretch, SolidsWithTwoOrThreeNearStretchesHaveTheirHessian) {
  Numbers numbers(31);
  for (const double gap : kGaps) {
    for (const double third : {1.3, 1.1 * (1.0 - gap), 1.1}) {
      const Eigen::Vector3d stretches(1.1 * (1.0 + gap), 1.1, third);
      const Eigen::Matrix3d turn = random_rotation(numbers);
      const Eigen::Matrix3d f = stretches.asDiagonal() * turn;
      compare<6>(solid_model(), z_of(f), gap);
    }
    const Eigen::Matrix3d aligned = Eigen::Vector3d(0.8, 0.8 * (1.0 + gap), 0.8).asDiagonal();
    compare<6>(solid_model(), z_of(aligned), gap);
  }
}

TEST(PrincipalStretch, MembranesWithNearStretchesHaveTheirHessian) {
  Numbers numbers(32);
  for (const double gap : kGaps) {
    for (int sample = 0; sample < 5; ++sample) {
      const Eigen::Rotation2Dd turn(numbers.between(-3.0, 3.0));
      const Eigen::Matrix2d f =
          Eigen::Vector2d(1.2 * (1.0 + gap), 1.2).asDiagonal() * turn.toRotationMatrix();
      const Eigen::Matrix2d c = f.transpose() * f;
      compare<3>(membrane_model(), Eigen::Vector3d(c(0, 0), c(1, 1), c(0, 1)), gap);
    }
  }
}

// At rest: isotropic elasticity with mu = mu alpha / 2 for Ogden, and lambda = 0.
TEST(PrincipalStretch, RestHasItsShearStiffness) {
  const model::Model ogden = model_of({{"solid_principal_stretches", "ogden", {70.0, 3.0}}});
  Eigen::Matrix<double, 6, 1> rest;
  rest << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0;
  const auto at = energy_at<6>(ogden, rest);
  EXPECT_EQ(at.by_z.norm(), 0.0);
  // Psi = mu tr(E^2) with E_ii = (z_i - 1)/2, E_ij = z/2: second derivatives mu/2 and mu
  constexpr double kShear = 70.0 * 3.0 / 2.0;
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(at.by_zz(k, k), (k < 3 ? 0.5 : 1.0) * kShear, 1e-11);
  EXPECT_NEAR(at.by_zz.norm(), kShear * std::sqrt(3.0 * 0.25 + 3.0), 1e-10);
}

}  // namespace
}  // namespace tenter::mechanics
