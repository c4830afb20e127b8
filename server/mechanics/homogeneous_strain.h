// SPDX-License-Identifier: GPL-3.0-or-later
// Homogeneous strain of a flat specimen in the axes of the test, and what the material axes see of
// it.
//
//   F = [[q0, q2], [0, q1]]   q = (stretch_x, stretch_y, shear_xy)
//
// Nominal stresses (N/m) are the derivatives of the energy per reference area by q: work-conjugate
// by construction. The material's weft lies at -axis_angle in test axes (the angle runs from weft
// to the test's x axis), so with a = (cos, -sin) and b = (sin, cos) of the axis angle: c = (a.C.a,
// b.C.b, a.C.b), C = F'F.
#pragma once

#include <Eigen/Core>

namespace tenter::mechanics {

class HomogeneousStrain {
 public:
  explicit HomogeneousStrain(double axis_angle_rad);

  /// c(q), its Jacobian (rows: c, columns: q) and its constant Hessians (c is quadratic in q).
  Eigen::Vector3d c(const Eigen::Vector3d& q) const;
  Eigen::Matrix3d c_by_q(const Eigen::Vector3d& q) const;
  const Eigen::Matrix3d& c_by_qq(int component) const { return hessian_[component]; }

 private:
  Eigen::Matrix3d hessian_[3];
};

}  // namespace tenter::mechanics
