// SPDX-License-Identifier: GPL-3.0-or-later
// Forces from outside that have a potential: gravity on nodes and clips, constant forces on nodes
// (hanging weights), cords on clips, and a pressure inside a closed surface.
//
//   V = - sum_i (m_i g + f_i) . x_i  - sum_clips (m g . c + sum_cords F . p)  -  pressure volume(x)
//
// The pressure is a constant one, so its force follows the surface; volume is the one enclosed by
// the triangles, whose normals point out:  sum over triangles  x_0 . (x_1 x x_2) / 6.
//
// Values and pure functions; no allocation.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"
#include "server/mechanics/conditions/boundary.h"
#include "server/mechanics/elements/node_matrix.h"

namespace tenter::mechanics {

struct Loads {
  Eigen::Vector3d gravity_m_s2 = {0.0, 0.0, -9.81};
  Eigen::VectorXd node_mass_kg;                            ///< one a node; empty: no weight
  Eigen::VectorXd node_force_N;                            ///< three a node; empty: none
  std::vector<std::vector<Eigen::Vector3d>> cord_force_N;  ///< [clip][cord]; empty: none
  double pressure_Pa = 0.0;  ///< inside the boundary's pressed surface
};

/// bad_input where a list has the wrong length or holds what is no number; masses are not negative.
Expected<void> check(const Loads& loads, const Boundary& boundary, int node_count);

/// What loads add to, where not null: energy (J), gradient over all nodes (N), stiffness.
struct LoadOutput {
  double* energy = nullptr;
  double* gradient = nullptr;
  NodeMatrix* stiffness = nullptr;
  double* energy_size = nullptr;  ///< magnitudes of what the energy is summed from, J
};

/// Adds V and its derivatives by the nodes; clips see below. A pressure needs the edges of its
/// surface among the pairs of the matrix.
void add_loads(const Loads& loads, const Boundary& boundary, const Eigen::VectorXd& x,
               const LoadOutput& output);

/// V of the weight and cords of one clip.
double clip_potential_J(const Loads& loads, const Boundary& boundary, int clip, const Pose& pose);

/// Force and torque that act on a clip from outside: cords and its own weight.
struct Wrench {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();  ///< about the point that was asked for
};
Wrench outer_wrench(const Loads& loads, const Boundary& boundary, int clip, const Pose& pose,
                    const Eigen::Vector3d& about_m);

/// What the cloth pulls at a clip, with the weight of its nodes (thesis 3.4.1): minus the gradient
/// of the whole energy, loads included, summed over its nodes. A clip at rest has
/// reaction + outer_wrench = 0 where it is free; where it is prescribed the sum is what the holder
/// has to bear.
Wrench reaction(const Clip& clip, const Eigen::VectorXd& x, const Eigen::VectorXd& gradient,
                const Eigen::Vector3d& about_m);

}  // namespace tenter::mechanics
