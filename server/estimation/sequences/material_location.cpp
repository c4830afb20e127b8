// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/material_location.h"

#include <Eigen/LU>
#include <algorithm>

namespace tenter::estimation {

namespace {

/// The triangle that the point lies deepest in, so far.
class Deepest {
 public:
  Deepest(const mechanics::SurfaceMesh& mesh, const Eigen::Vector2d& material_m)
      : mesh_(mesh), material_m_(material_m) {}

  void offer(const std::array<int, 3>& corners) {
    const Eigen::Vector2d origin = mesh_.material_m.col(corners[0]);
    Eigen::Matrix2d edges;
    edges << mesh_.material_m.col(corners[1]) - origin, mesh_.material_m.col(corners[2]) - origin;
    const Eigen::Vector2d w = edges.inverse() * (material_m_ - origin);
    const double lowest = std::min({w[0], w[1], 1.0 - w[0] - w[1]});
    if (lowest <= lowest_) return;
    lowest_ = lowest;
    best_ = MaterialLocation{corners, {1.0 - w[0] - w[1], w[0], w[1]}};
  }
  const std::optional<MaterialLocation>& best() const { return best_; }

 private:
  static constexpr double kOutside = 1e-6;
  const mechanics::SurfaceMesh& mesh_;
  const Eigen::Vector2d material_m_;
  double lowest_ = -kOutside;
  std::optional<MaterialLocation> best_;
};

}  // namespace

std::optional<MaterialLocation> locate(const mechanics::SurfaceMesh& mesh,
                                       const Eigen::Vector2d& material_m) {
  Deepest deepest(mesh, material_m);
  for (const auto& corners : mesh.triangles) deepest.offer(corners);
  return deepest.best();
}

std::optional<MaterialLocation> locate(const mechanics::SurfaceMesh& mesh,
                                       const Eigen::Vector2d& material_m,
                                       const std::vector<int>& triangles) {
  Deepest deepest(mesh, material_m);
  for (const int t : triangles) deepest.offer(mesh.triangles[static_cast<std::size_t>(t)]);
  return deepest.best();
}

}  // namespace tenter::estimation
