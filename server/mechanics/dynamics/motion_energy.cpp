// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/dynamics/motion_energy.h"

#include <Eigen/Geometry>

namespace tenter::mechanics {

Momenta momenta(const Boundary& boundary, const Eigen::VectorXd& node_mass_kg, const Motion& motion,
                const Eigen::Vector3d& about_m) {
  Momenta sum;
  const auto count = [&](double mass, const Eigen::Vector3d& x, Eigen::Index point) {
    const Eigen::Vector3d v = motion.velocity_m_s.segment<3>(3 * point);
    sum.kinetic_J += 0.5 * mass * v.squaredNorm();
    sum.momentum_kg_m_s += mass * v;
    sum.angular_kg_m2_s += mass * (x - about_m).cross(v);
  };
  for (Eigen::Index i = 0; i < node_mass_kg.size(); ++i)
    count(node_mass_kg[i], motion.at.x.segment<3>(3 * i), i);
  for (std::size_t c = 0; c < boundary.clips.size(); ++c) {
    const Clip& clip = boundary.clips[c];
    if (clip.is_free)
      count(clip.mass_kg, motion.at.clips[c].to_space(clip.centre_of_mass_m),
            node_mass_kg.size() + static_cast<Eigen::Index>(c));
  }
  return sum;
}

}  // namespace tenter::mechanics
