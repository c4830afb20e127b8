// SPDX-License-Identifier: GPL-3.0-or-later
// An energy of positions that Potential adds to material, loads and contact: the inertia of a time
// step (dynamics/inertia.h), the barrier of a strip with itself.
//
//   Potential potential(model, parameters, boundary, unknowns, loads, contact, limits, history,
//   &inertia);
//
// Const members are callable from any thread and allocate nothing after the first call.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/mechanics/conditions/loads.h"

namespace tenter::mechanics {

/// k/2 |p - target|^2 of a point p of a free clip.
struct ClipSpring {
  int clip = 0;
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();  ///< in the clip's frame
  double stiffness_N_m = 0.0;
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();
};

class NodeEnergy {
 public:
  NodeEnergy() = default;
  NodeEnergy(const NodeEnergy&) = default;
  NodeEnergy& operator=(const NodeEnergy&) = default;
  virtual ~NodeEnergy() = default;

  /// Adds energy and derivatives over all nodes; the energy is infinite where x is out of reach.
  /// `positive_share`: how much of the stiffness that is never positive is left out, 0 to 1.
  virtual void add(const Eigen::VectorXd& x, const LoadOutput& output,
                   double positive_share) const = 0;
  /// Asked before every step of a minimisation: how much of the way from `from` to `to` may be
  /// gone. What follows is evaluated between both.
  virtual double longest_fraction(const Eigen::VectorXd& /*from*/, const Eigen::VectorXd& /*to*/) {
    return 1.0;
  }
  /// What it does to free clips besides their nodes.
  virtual const std::vector<ClipSpring>& clip_springs() const = 0;
};

}  // namespace tenter::mechanics
