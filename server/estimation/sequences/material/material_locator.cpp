// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/material/material_locator.h"

#include <algorithm>
#include <cmath>

namespace tenter::estimation {

namespace {

constexpr double kTrianglesPerBin = 2.0;
constexpr int kMostBins = 2000;  // along one side

}  // namespace

MaterialLocator::MaterialLocator(const mechanics::SurfaceMesh& mesh) : mesh_(mesh) {
  lowest_m_ = mesh.material_m.rowwise().minCoeff();
  const Eigen::Vector2d size = mesh.material_m.rowwise().maxCoeff() - lowest_m_;
  bin_m_ = std::sqrt(size.prod() * kTrianglesPerBin / mesh.triangle_count());
  bin_m_ = std::max(bin_m_, size.maxCoeff() / kMostBins);
  bins_u_ = static_cast<int>(size.x() / bin_m_) + 1;
  bins_v_ = static_cast<int>(size.y() / bin_m_) + 1;
  triangles_.resize(static_cast<std::size_t>(bins_u_) * static_cast<std::size_t>(bins_v_));
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto& corners = mesh.triangles[static_cast<std::size_t>(t)];
    Eigen::Matrix<double, 2, 3> place;
    for (int a = 0; a < 3; ++a)
      place.col(a) = mesh.material_m.col(corners[static_cast<std::size_t>(a)]);
    // wider than what locate() takes as inside
    const Eigen::Vector2d margin =
        1e-5 * (place.rowwise().maxCoeff() - place.rowwise().minCoeff()) +
        Eigen::Vector2d::Constant(1e-9 * size.maxCoeff());
    const Eigen::Vector2d lo = place.rowwise().minCoeff() - margin;
    const Eigen::Vector2d hi = place.rowwise().maxCoeff() + margin;
    for (int v = bin_of(lo.y(), lowest_m_.y(), bins_v_);
         v <= bin_of(hi.y(), lowest_m_.y(), bins_v_); ++v)
      for (int u = bin_of(lo.x(), lowest_m_.x(), bins_u_);
           u <= bin_of(hi.x(), lowest_m_.x(), bins_u_); ++u)
        triangles_[static_cast<std::size_t>(v * bins_u_ + u)].push_back(t);
  }
}

int MaterialLocator::bin_of(double value_m, double lowest_m, int bins) const {
  return static_cast<int>(std::clamp((value_m - lowest_m) / bin_m_, 0.0, bins - 1.0));
}

std::optional<MaterialLocation> MaterialLocator::locate(const Eigen::Vector2d& material_m) const {
  const int bin = bin_of(material_m.y(), lowest_m_.y(), bins_v_) * bins_u_ +
                  bin_of(material_m.x(), lowest_m_.x(), bins_u_);
  return estimation::locate(mesh_, material_m, triangles_[static_cast<std::size_t>(bin)]);
}

}  // namespace tenter::estimation
