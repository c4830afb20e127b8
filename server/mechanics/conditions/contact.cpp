// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/conditions/contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace tenter::mechanics {
namespace {

Gap gap_of(const Plane& plane, const Eigen::Vector3d& x) {
  return {plane.normal.dot(x - plane.point_m), plane.normal, Eigen::Matrix3d::Zero()};
}

Gap gap_of(const Cylinder& cylinder, const Eigen::Vector3d& x) {
  const Eigen::Matrix3d across =
      Eigen::Matrix3d::Identity() - cylinder.axis * cylinder.axis.transpose();
  const Eigen::Vector3d radial = across * (x - cylinder.point_m);
  const double distance = radial.norm();
  Gap result;
  result.value_m = distance - cylinder.radius_m;
  constexpr double kOnAxis = 1e-9;  // of the radius
  if (distance <= kOnAxis * cylinder.radius_m) {
    result.normal = cylinder.axis.unitOrthogonal();
    return result;
  }
  result.normal = radial / distance;
  result.curvature = (across - result.normal * result.normal.transpose()) / distance;
  return result;
}

Gap gap_of(const Sphere& sphere, const Eigen::Vector3d& x) {
  const Eigen::Vector3d radial = x - sphere.point_m;
  const double distance = radial.norm();
  Gap result;
  result.value_m = distance - sphere.radius_m;
  constexpr double kInMiddle = 1e-9;  // of the radius
  if (distance <= kInMiddle * sphere.radius_m) {
    result.normal = Eigen::Vector3d::UnitZ();
    return result;
  }
  result.normal = radial / distance;
  result.curvature =
      (Eigen::Matrix3d::Identity() - result.normal * result.normal.transpose()) / distance;
  return result;
}

bool is_unit(const Eigen::Vector3d& v) {
  return std::abs(v.norm() - 1.0) < 1e-9;
}

}  // namespace

Expected<void> check(const std::vector<Obstacle>& obstacles) {
  for (const Obstacle& obstacle : obstacles) {
    if (const auto* plane = std::get_if<Plane>(&obstacle)) {
      if (!is_unit(plane->normal) || !plane->point_m.allFinite())
        return bad_input("the plane's normal must be of length one, its point finite");
    } else if (const auto* cylinder = std::get_if<Cylinder>(&obstacle)) {
      if (!is_unit(cylinder->axis) || !cylinder->point_m.allFinite())
        return bad_input("the cylinder's axis must be of length one, its point finite");
      if (!(cylinder->radius_m > 0.0) || !std::isfinite(cylinder->radius_m))
        return bad_input("the cylinder's radius must be positive");
    } else {
      const auto& sphere = std::get<Sphere>(obstacle);
      if (!sphere.point_m.allFinite() || !(sphere.radius_m > 0.0) ||
          !std::isfinite(sphere.radius_m))
        return bad_input("the sphere's middle must be finite, its radius positive");
    }
  }
  return {};
}

Gap gap(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  return std::visit([&x](const auto& shape) { return gap_of(shape, x); }, obstacle);
}

Contact::Contact(std::vector<Obstacle> obstacles, std::vector<int> nodes, double penalty_N_m)
    : obstacles_(std::move(obstacles)), nodes_(std::move(nodes)), penalty_N_m_(penalty_N_m) {
  force_N_.setZero(static_cast<Eigen::Index>(obstacles_.size() * nodes_.size()));
}

void Contact::add(const Eigen::VectorXd& x, const LoadOutput& output, double positive_share) const {
  Eigen::Index k = 0;
  for (const Obstacle& obstacle : obstacles_) {
    for (const int node : nodes_) {
      const double lambda = force_N_[k++];
      const Gap g = gap(obstacle, x.segment<3>(3 * node));
      const double force = lambda - penalty_N_m_ * g.value_m;
      const double energy =
          (std::max(0.0, force) * std::max(0.0, force) - lambda * lambda) / (2.0 * penalty_N_m_);
      if (output.energy) *output.energy += energy;
      if (output.energy_size) *output.energy_size += std::abs(energy);
      if (force <= 0.0) continue;
      if (output.gradient)
        Eigen::Map<Eigen::Vector3d>(output.gradient + 3 * node) -= force * g.normal;
      if (!output.stiffness) continue;
      Eigen::Map<Eigen::Matrix3d> block(
          output.stiffness->block(output.stiffness->slot(node, node)));
      block += penalty_N_m_ * g.normal * g.normal.transpose();
      block -= (1.0 - positive_share) * force * g.curvature;
    }
  }
}

double Contact::violation_m(const Eigen::VectorXd& x) const {
  double worst = 0.0;
  Eigen::Index k = 0;
  for (const Obstacle& obstacle : obstacles_) {
    for (const int node : nodes_) {
      const double g = gap(obstacle, x.segment<3>(3 * node)).value_m;
      worst = std::max(worst, std::abs(std::min(g, force_N_[k++] / penalty_N_m_)));
    }
  }
  return worst;
}

std::vector<Contact::Touch> Contact::touches(const Eigen::VectorXd& x) const {
  std::vector<Touch> result;
  Eigen::Index k = 0;
  for (const Obstacle& obstacle : obstacles_) {
    for (const int node : nodes_) {
      const Gap g = gap(obstacle, x.segment<3>(3 * static_cast<Eigen::Index>(node)));
      if (force_N_[k++] - penalty_N_m_ * g.value_m > 0.0) result.push_back({node, g.normal});
    }
  }
  return result;
}

Eigen::VectorXd Contact::acting_forces_N(const Eigen::VectorXd& x) const {
  Eigen::VectorXd acting = force_N_;
  Eigen::Index k = 0;
  for (const Obstacle& obstacle : obstacles_) {
    for (const int node : nodes_) {
      const double g = gap(obstacle, x.segment<3>(3 * static_cast<Eigen::Index>(node))).value_m;
      acting[k] = std::max(0.0, force_N_[k] - penalty_N_m_ * g);
      ++k;
    }
  }
  return acting;
}

void Contact::update_forces(const Eigen::VectorXd& x) {
  force_N_ = acting_forces_N(x);
}

}  // namespace tenter::mechanics
