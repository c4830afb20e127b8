// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/conditions/loads.h"

#include <Eigen/Geometry>
#include <cmath>
#include <string>

namespace tenter::mechanics {
namespace {

/// block (i, j) += k, wherever the triangle below the diagonal holds it.
void add_block(NodeMatrix& matrix, int i, int j, const Eigen::Matrix3d& k) {
  Eigen::Map<Eigen::Matrix3d> block(matrix.block(i >= j ? matrix.slot(i, j) : matrix.slot(j, i)));
  if (i >= j)
    block += k;
  else
    block += k.transpose();
}

void add_pressure(double pressure_Pa, const Boundary& boundary, const Eigen::VectorXd& x,
                  const LoadOutput& output) {
  for (const auto& corners : boundary.pressed) {
    Eigen::Vector3d p[3];
    for (int c = 0; c < 3; ++c) p[c] = x.segment<3>(3 * corners[static_cast<std::size_t>(c)]);
    const double part = -pressure_Pa / 6.0;
    const double energy = part * p[0].dot(p[1].cross(p[2]));
    if (output.energy) *output.energy += energy;
    if (output.energy_size) *output.energy_size += std::abs(energy);
    for (int c = 0; c < 3; ++c) {
      const int next = (c + 1) % 3;
      const int last = (c + 2) % 3;
      const int node = corners[static_cast<std::size_t>(c)];
      if (output.gradient)
        Eigen::Map<Eigen::Vector3d>(output.gradient + 3 * node) += part * p[next].cross(p[last]);
      // d2V/dp_c dp_next: the cross product with the third corner
      if (output.stiffness)
        add_block(*output.stiffness, node, corners[static_cast<std::size_t>(next)],
                  -part * cross_matrix(p[last]));
    }
  }
}

}  // namespace

Expected<void> check(const Loads& loads, const Boundary& boundary, int node_count) {
  const auto fits = [](const Eigen::VectorXd& v, Eigen::Index size) {
    return v.size() == 0 || (v.size() == size && v.allFinite());
  };
  if (!loads.gravity_m_s2.allFinite()) return bad_input("gravity is no number");
  if (!fits(loads.node_mass_kg, node_count) || (loads.node_mass_kg.array() < 0.0).any())
    return bad_input("the masses must be one number a node, none of them negative");
  if (!fits(loads.node_force_N, 3 * static_cast<Eigen::Index>(node_count)))
    return bad_input("the forces on nodes must be three numbers a node");
  if (!loads.cord_force_N.empty() && loads.cord_force_N.size() != boundary.clips.size())
    return bad_input("cord forces are given for " + std::to_string(loads.cord_force_N.size()) +
                     " clips, of which there are " + std::to_string(boundary.clips.size()));
  for (std::size_t c = 0; c < loads.cord_force_N.size(); ++c) {
    const Clip& clip = boundary.clips[c];
    if (loads.cord_force_N[c].size() != clip.cord_place_m.size())
      return bad_input("clip \"" + clip.id + "\" has " + std::to_string(clip.cord_place_m.size()) +
                       " cords and forces for " + std::to_string(loads.cord_force_N[c].size()));
    for (const Eigen::Vector3d& f : loads.cord_force_N[c])
      if (!f.allFinite()) return bad_input("a cord force of clip \"" + clip.id + "\" is no number");
  }
  if (!std::isfinite(loads.pressure_Pa)) return bad_input("the pressure is no number");
  return {};
}

void add_loads(const Loads& loads, const Boundary& boundary, const Eigen::VectorXd& x,
               const LoadOutput& output) {
  for (Eigen::Index i = 0; i < loads.node_mass_kg.size(); ++i) {
    const Eigen::Vector3d weight = loads.node_mass_kg[i] * loads.gravity_m_s2;
    const double energy = -weight.dot(x.segment<3>(3 * i));
    if (output.energy) *output.energy += energy;
    if (output.energy_size) *output.energy_size += std::abs(energy);
    if (output.gradient) Eigen::Map<Eigen::Vector3d>(output.gradient + 3 * i) -= weight;
  }
  if (loads.node_force_N.size() > 0) {
    if (output.energy) *output.energy -= loads.node_force_N.dot(x);
    if (output.energy_size) *output.energy_size += loads.node_force_N.cwiseProduct(x).lpNorm<1>();
    if (output.gradient)
      Eigen::Map<Eigen::VectorXd>(output.gradient, x.size()) -= loads.node_force_N;
  }
  if (loads.pressure_Pa != 0.0) add_pressure(loads.pressure_Pa, boundary, x, output);
}

double clip_potential_J(const Loads& loads, const Boundary& boundary, int clip, const Pose& pose) {
  const Clip& body = boundary.clips[static_cast<std::size_t>(clip)];
  double potential = -body.mass_kg * loads.gravity_m_s2.dot(pose.to_space(body.centre_of_mass_m));
  if (loads.cord_force_N.empty()) return potential;
  const auto& forces = loads.cord_force_N[static_cast<std::size_t>(clip)];
  for (std::size_t k = 0; k < forces.size(); ++k)
    potential -= forces[k].dot(pose.to_space(body.cord_place_m[k]));
  return potential;
}

Wrench outer_wrench(const Loads& loads, const Boundary& boundary, int clip, const Pose& pose,
                    const Eigen::Vector3d& about_m) {
  const Clip& body = boundary.clips[static_cast<std::size_t>(clip)];
  Wrench wrench;
  const auto add = [&](const Eigen::Vector3d& force, const Eigen::Vector3d& place) {
    wrench.force_N += force;
    wrench.torque_N_m += (pose.to_space(place) - about_m).cross(force);
  };
  add(body.mass_kg * loads.gravity_m_s2, body.centre_of_mass_m);
  if (loads.cord_force_N.empty()) return wrench;
  const auto& forces = loads.cord_force_N[static_cast<std::size_t>(clip)];
  for (std::size_t k = 0; k < forces.size(); ++k) add(forces[k], body.cord_place_m[k]);
  return wrench;
}

Wrench reaction(const Clip& clip, const Eigen::VectorXd& x, const Eigen::VectorXd& gradient,
                const Eigen::Vector3d& about_m) {
  Wrench wrench;
  for (const int node : clip.nodes) {
    const Eigen::Vector3d pull = -gradient.segment<3>(3 * node);
    const Eigen::Vector3d arm = x.segment<3>(3 * node) - about_m;
    wrench.force_N += pull;
    wrench.torque_N_m += arm.cross(pull);
  }
  return wrench;
}

}  // namespace tenter::mechanics
