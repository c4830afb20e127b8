// SPDX-License-Identifier: GPL-3.0-or-later
// Which nodes of a mesh are free, held in place, or fixed to a rigid clip.
//
//   Boundary boundary;
//   boundary.held = nodes_above(mesh, table_edge);           // stay where the state has them
//   boundary.clips = {clip_on(nodes, x, pose)};              // prescribed: goes where it is put
//   boundary.clips[0].is_free = true;                        // or moves under cords and gravity
//   if (auto ok = check(boundary, mesh.node_count()); !ok) ...
//   State state{x, {pose}};
//   place_clips(boundary, state);                            // after a pose was changed
//
// A clip's own frame is what its `place_m` are given in; a pose takes it to space,
// x = rotation place + position.
//
// Values and pure functions.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace tenter::mechanics {

struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();

  Eigen::Vector3d to_space(const Eigen::Vector3d& place_m) const {
    return rotation * place_m + position_m;
  }
};

/// A rigid body that nodes are clamped in (thesis 3.4.1).
struct Clip {
  std::string id;
  std::vector<int> nodes;
  std::vector<Eigen::Vector3d> place_m;       ///< of each node, in the clip's frame
  std::vector<Eigen::Vector3d> cord_place_m;  ///< where cords are tied, in the clip's frame
  bool is_free = false;                       ///< moves; else its pose is prescribed
  double mass_kg = 0.0;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();  ///< in the clip's frame
};

struct Boundary {
  std::vector<int> held;
  std::vector<Clip> clips;
  std::vector<std::array<int, 3>> pressed;  ///< closed surface under pressure, normals outwards
};

/// Positions of all nodes, 3 numbers each (m), and the pose of every clip.
struct State {
  Eigen::VectorXd x;
  std::vector<Pose> clips;
};

/// bad_input names the clip or node: an index out of range, a node in two places, a clip without
/// nodes, places that do not match its nodes, a free clip whose nodes, cords and weight all lie on
/// one line (nothing determines its turn about it), a mass that is no number or negative.
Expected<void> check(const Boundary& boundary, int node_count);

/// bad_input where the state has other sizes, a position is no number, or a pose no rotation.
Expected<void> check(const State& state, const Boundary& boundary, int node_count);

/// The clip that holds `nodes` where they are when it is at `pose`.
Clip clip_on(std::string id, std::vector<int> nodes, const Eigen::VectorXd& x, const Pose& pose);

/// Puts the nodes of every clip where its pose says.
void place_clips(const Boundary& boundary, State& state);

/// Rotation by the vector w: |w| radians about its direction.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& w);

/// [a]x: cross_matrix(a) b = a x b.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a);

}  // namespace tenter::mechanics
