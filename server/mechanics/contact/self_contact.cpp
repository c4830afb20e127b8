// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/contact/self_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "server/mechanics/contact/point_triangle.h"

namespace tenter::mechanics {
namespace {

PointAndTriangle gather(const Eigen::VectorXd& x, const NearPairs::Pair& pair) {
  PointAndTriangle result;
  for (int c = 0; c < 4; ++c)
    result.col(c) = x.segment<3>(3 * static_cast<Eigen::Index>(pair[static_cast<std::size_t>(c)]));
  return result;
}

double smallest_height_m(const SurfaceMesh& mesh) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector2d ab = mesh.way_m(t[0], t[1]), ac = mesh.way_m(t[0], t[2]);
    const double twice_area = std::abs(ab.x() * ac.y() - ab.y() * ac.x());
    smallest = std::min(smallest, twice_area / std::max({ab.norm(), ac.norm(), (ac - ab).norm()}));
  }
  return smallest;
}

}  // namespace

Expected<SelfContact> SelfContact::make(const SurfaceMesh& mesh, double thickness_m,
                                        double stiffness_N_m) {
  if (!(thickness_m > 0.0) || !std::isfinite(thickness_m))
    return bad_input("the thickness of self-contact is " + std::to_string(thickness_m) +
                     " m and must be positive");
  if (!(stiffness_N_m > 0.0) || !std::isfinite(stiffness_N_m))
    return bad_input("the stiffness of self-contact must be positive");
  if (const double height = smallest_height_m(mesh); thickness_m > 0.5 * height)
    return bad_input("the thickness of self-contact is " + std::to_string(thickness_m) +
                     " m, more than half of the smallest height of a triangle, " +
                     std::to_string(height) + " m");
  SelfContact contact;
  contact.pairs_ = NearPairs(mesh);
  contact.thickness_m_ = thickness_m;
  contact.stiffness_N_m_ = stiffness_N_m;
  return contact;
}

void SelfContact::begin(const Eigen::VectorXd& x) {
  pairs_.find(x, x, thickness_m_);
}

double SelfContact::longest_fraction(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  pairs_.find(from, to, thickness_m_);
  double share = 1.0;
  for (const NearPairs::Pair& pair : pairs_.list())
    share = std::min(share, free_share(gather(from, pair), gather(to, pair)));
  return share;
}

void SelfContact::add(const Eigen::VectorXd& x, const LoadOutput& output, double) const {
  for (const NearPairs::Pair& pair : pairs_.list()) {
    const PointTriangle near = point_triangle(gather(x, pair));
    const double d = near.distance_m, h = thickness_m_;
    if (d >= h) continue;
    if (d <= 0.0) {
      if (output.energy) *output.energy = std::numeric_limits<double>::infinity();
      return;
    }
    const double off = d - h, log = std::log(d / h);
    const double energy = -stiffness_N_m_ * off * off * log;
    const double slope = stiffness_N_m_ * (-2.0 * off * log - off * off / d);
    const double curvature = stiffness_N_m_ * (-2.0 * log - 4.0 * off / d + off * off / (d * d));
    if (output.energy) *output.energy += energy;
    if (output.energy_size) *output.energy_size += energy;
    for (std::size_t c = 0; c < 4; ++c) {
      const double weight = c == 0 ? 1.0 : -near.weight[static_cast<Eigen::Index>(c) - 1];
      if (weight == 0.0) continue;
      const auto node = static_cast<std::size_t>(pair[c]);
      if (output.gradient)
        Eigen::Map<Eigen::Vector3d>(output.gradient + 3 * node) += slope * weight * near.normal;
      if (!output.stiffness) continue;
      // the sum of all |w| is 2
      Eigen::Map<Eigen::Matrix3d> block(
          output.stiffness->block(output.stiffness->column_start()[node]));
      block += 2.0 * std::abs(weight) * curvature * near.normal * near.normal.transpose();
    }
  }
}

double SelfContact::nearest_m(const Eigen::VectorXd& x) {
  begin(x);
  double nearest = thickness_m_;
  for (const NearPairs::Pair& pair : pairs_.list())
    nearest = std::min(nearest, point_triangle(gather(x, pair)).distance_m);
  return nearest;
}

}  // namespace tenter::mechanics
