// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/homogeneous_strain.h"

#include <cmath>

namespace tenter::mechanics {

// C = F'F has C_xx = q0^2, C_xy = q0 q2, C_yy = q1^2 + q2^2, so each component of c is w.(C_xx,
// C_yy, C_xy) and half its Hessian by q is [[wx, 0, wxy/2], [0, wy, 0], [wxy/2, 0, wy]]: c_i = q'
// (H_i/2) q.
HomogeneousStrain::HomogeneousStrain(double axis_angle_rad) {
  const double co = std::cos(axis_angle_rad);
  const double si = std::sin(axis_angle_rad);
  const Eigen::Vector2d a(co, -si);
  const Eigen::Vector2d b(si, co);
  const auto weights = [](const Eigen::Vector2d& l, const Eigen::Vector2d& r) {
    return Eigen::Vector3d(l[0] * r[0], l[1] * r[1], l[0] * r[1] + l[1] * r[0]);
  };
  const Eigen::Vector3d rows[3] = {weights(a, a), weights(b, b), weights(a, b)};
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d& w = rows[i];
    hessian_[i] << 2.0 * w[0], 0.0, w[2], 0.0, 2.0 * w[1], 0.0, w[2], 0.0, 2.0 * w[1];
  }
}

Eigen::Vector3d HomogeneousStrain::c(const Eigen::Vector3d& q) const {
  Eigen::Vector3d result;
  for (int i = 0; i < 3; ++i) result[i] = 0.5 * q.dot(hessian_[i] * q);
  return result;
}

Eigen::Matrix3d HomogeneousStrain::c_by_q(const Eigen::Vector3d& q) const {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) result.row(i) = (hessian_[i] * q).transpose();
  return result;
}

}  // namespace tenter::mechanics
