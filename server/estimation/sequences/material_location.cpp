// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/material_location.h"

#include <Eigen/LU>
#include <algorithm>

namespace tenter::estimation {

std::optional<MaterialLocation> locate(const mechanics::SurfaceMesh& mesh,
                                       const Eigen::Vector2d& material_m) {
  constexpr double kOutside = 1e-6;
  std::optional<MaterialLocation> best;
  double best_lowest = -kOutside;
  for (const auto& corners : mesh.triangles) {
    const Eigen::Vector2d origin = mesh.material_m.col(corners[0]);
    Eigen::Matrix2d edges;
    edges << mesh.material_m.col(corners[1]) - origin, mesh.material_m.col(corners[2]) - origin;
    const Eigen::Vector2d w = edges.inverse() * (material_m - origin);
    const double lowest = std::min({w[0], w[1], 1.0 - w[0] - w[1]});
    if (lowest <= best_lowest) continue;
    best_lowest = lowest;
    best = MaterialLocation{corners, {1.0 - w[0] - w[1], w[0], w[1]}};
  }
  return best;
}

}  // namespace tenter::estimation
