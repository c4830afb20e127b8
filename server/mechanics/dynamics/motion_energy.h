// SPDX-License-Identifier: GPL-3.0-or-later
// Kinetic energy and momenta of a mesh in motion, with lumped masses; free clips with theirs.
//
//   T = 1/2 sum m |v|^2     P = sum m v     L = sum m (x - about) x v
//
// Nodes that are held count: their velocity is zero. Pure functions, O(nodes).
#pragma once

#include <Eigen/Core>

#include "server/mechanics/dynamics/time_scheme.h"

namespace tenter::mechanics {

struct Momenta {
  double kinetic_J = 0.0;
  Eigen::Vector3d momentum_kg_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_kg_m2_s = Eigen::Vector3d::Zero();
};

/// `node_mass_kg`: one a node.
Momenta momenta(const Boundary& boundary, const Eigen::VectorXd& node_mass_kg, const Motion& motion,
                const Eigen::Vector3d& about_m = Eigen::Vector3d::Zero());

}  // namespace tenter::mechanics
