// SPDX-License-Identifier: GPL-3.0-or-later
// Random deformation gradients of solids, with fixed seeds.
#pragma once

#include <Eigen/Dense>

#include "tests/server/mechanics/differences.h"

namespace tenter::testing {

/// Large strains, shear included, never near collapse.
inline Eigen::Matrix3d random_solid(Numbers& numbers) {
  Eigen::Matrix3d f;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      f(i, j) = i == j ? numbers.between(0.7, 1.6) : numbers.between(-0.25, 0.25);
  return f;
}

inline Eigen::Matrix3d random_rotation(Numbers& numbers) {
  Eigen::Vector4d q;
  for (int i = 0; i < 4; ++i) q[i] = numbers.between(-1.0, 1.0);
  return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
}

/// (C_xx, C_yy, C_zz, C_yz, C_xz, C_xy)
inline Eigen::Matrix<double, 6, 1> z_of(const Eigen::Matrix3d& f) {
  const Eigen::Matrix3d c = f.transpose() * f;
  Eigen::Matrix<double, 6, 1> z;
  z << c(0, 0), c(1, 1), c(2, 2), c(1, 2), c(0, 2), c(0, 1);
  return z;
}

}  // namespace tenter::testing
