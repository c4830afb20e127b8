// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/hexahedron.h"

#include <Eigen/LU>
#include <cmath>

namespace tenter::mechanics {

const HexahedronCorners& hexahedron_corners() {
  static const HexahedronCorners corners = [] {
    HexahedronCorners c;
    c << -1, 1, 1, -1, -1, 1, 1, -1,  //
        -1, -1, 1, 1, -1, -1, 1, 1,   //
        -1, -1, -1, -1, 1, 1, 1, 1;
    return c;
  }();
  return corners;
}

HexahedronCorners hexahedron_gauss_points() {
  return hexahedron_corners() / std::sqrt(3.0);
}

Eigen::Matrix<double, 8, 1> hexahedron_shape(const Eigen::Vector3d& xi) {
  const HexahedronCorners& c = hexahedron_corners();
  Eigen::Matrix<double, 8, 1> shape;
  for (int a = 0; a < 8; ++a)
    shape[a] = 0.125 * (1 + xi[0] * c(0, a)) * (1 + xi[1] * c(1, a)) * (1 + xi[2] * c(2, a));
  return shape;
}

Eigen::Matrix<double, 8, 3> hexahedron_slopes(const Eigen::Vector3d& xi) {
  const HexahedronCorners& c = hexahedron_corners();
  Eigen::Matrix<double, 8, 3> slopes;
  for (int a = 0; a < 8; ++a) {
    const double x = 1 + xi[0] * c(0, a);
    const double y = 1 + xi[1] * c(1, a);
    const double z = 1 + xi[2] * c(2, a);
    slopes.row(a) << 0.125 * c(0, a) * y * z, 0.125 * x * c(1, a) * z, 0.125 * x * y * c(2, a);
  }
  return slopes;
}

double hexahedron_jacobian(const HexahedronCorners& rest_m, const Eigen::Vector3d& xi) {
  const Eigen::Matrix3d jacobian = rest_m * hexahedron_slopes(xi);
  return jacobian.determinant();
}

}  // namespace tenter::mechanics
