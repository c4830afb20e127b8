// SPDX-License-Identifier: GPL-3.0-or-later
// locate() for many points of one mesh: triangles are sorted into square bins first.
//
//   const MaterialLocator locator(mesh);
//   const std::optional<MaterialLocation> place = locator.locate(material_m);   // as locate()
//
// Making is linear in the triangles; a look-up takes those of one bin, a few on even meshes. The
// mesh must outlive this. Reading is safe from any thread.
#pragma once

#include <vector>

#include "server/estimation/sequences/material_location.h"

namespace tenter::estimation {

class MaterialLocator {
 public:
  explicit MaterialLocator(const mechanics::SurfaceMesh& mesh);
  /// The same answer as locate(mesh, material_m).
  std::optional<MaterialLocation> locate(const Eigen::Vector2d& material_m) const;

 private:
  int bin_of(double value_m, double lowest_m, int bins) const;

  const mechanics::SurfaceMesh& mesh_;
  Eigen::Vector2d lowest_m_ = Eigen::Vector2d::Zero();
  double bin_m_ = 1.0;
  int bins_u_ = 1, bins_v_ = 1;
  std::vector<std::vector<int>> triangles_;  ///< [bin], rising
};

}  // namespace tenter::estimation
