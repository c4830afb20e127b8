// SPDX-License-Identifier: GPL-3.0-or-later
// Where in a mesh a point of the material is: three nodes and their weights.
//
//   x(point) = sum over corners  weight_a x_a
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "server/mechanics/mesh/surface_mesh.h"

namespace tenter::estimation {

struct MaterialLocation {
  std::array<int, 3> nodes = {0, 0, 0};
  std::array<double, 3> weight = {0.0, 0.0, 0.0};  ///< they sum to one

  Eigen::Vector3d position(const Eigen::VectorXd& x) const {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (std::size_t a = 0; a < 3; ++a)
      p += weight[a] * x.segment<3>(3 * static_cast<Eigen::Index>(nodes[a]));
    return p;
  }
  /// Whether these nodes, one flag a node of the mesh, are all that carry it.
  bool lies_on(const std::vector<bool>& nodes_of_mesh) const {
    constexpr double kNothing = 1e-9;
    for (std::size_t a = 0; a < 3; ++a)
      if (std::abs(weight[a]) >= kNothing && !nodes_of_mesh[static_cast<std::size_t>(nodes[a])])
        return false;
    return true;
  }
};

/// None where the point is outside of every triangle by more than a millionth of its size. Linear
/// in the number of triangles.
std::optional<MaterialLocation> locate(const mechanics::SurfaceMesh& mesh,
                                       const Eigen::Vector2d& material_m);

/// The same among some triangles, in this order.
std::optional<MaterialLocation> locate(const mechanics::SurfaceMesh& mesh,
                                       const Eigen::Vector2d& material_m,
                                       const std::vector<int>& triangles);

}  // namespace tenter::estimation
