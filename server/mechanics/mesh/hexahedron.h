// SPDX-License-Identifier: GPL-3.0-or-later
// The trilinear hexahedron: shape functions, their slopes, the Jacobian and the Gauss points on
// which its integrals are taken.
//
//   N_a = (1 + xi xi_a)(1 + eta eta_a)(1 + zeta zeta_a) / 8,   J = X dN/dxi
//
// det J is quadratic and N_a det J cubic in each coordinate: 2 points an axis integrate both
// exactly.
#pragma once

#include <Eigen/Core>
#include <array>

namespace tenter::mechanics {

using HexahedronCorners = Eigen::Matrix<double, 3, 8>;

/// Reference coordinates of the corners, one a column.
const HexahedronCorners& hexahedron_corners();

/// Reference coordinates of the 2 x 2 x 2 Gauss points (weight 1 each), in the order of the
/// corners.
HexahedronCorners hexahedron_gauss_points();

/// Shape functions at a reference point.
Eigen::Matrix<double, 8, 1> hexahedron_shape(const Eigen::Vector3d& xi);

/// Their slopes: row a, column of the reference axis.
Eigen::Matrix<double, 8, 3> hexahedron_slopes(const Eigen::Vector3d& xi);

/// det(X dN/dxi), X the corners' rest positions.
double hexahedron_jacobian(const HexahedronCorners& rest_m, const Eigen::Vector3d& xi);

}  // namespace tenter::mechanics
