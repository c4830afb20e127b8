// SPDX-License-Identifier: GPL-3.0-or-later
// A scene in the terms of conditions/: who is held, what stands in the way, where everything
// starts, and which loads belong to given levels.
//
//   Expected<SetUp> set_up = make_set_up(scene, body);
//   Loads loads = loads_at(*set_up, body, levels);
//
// Pure functions.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"
#include "common/scene/scene.h"
#include "server/mechanics/conditions/boundary.h"
#include "server/mechanics/conditions/contact.h"
#include "server/mechanics/conditions/loads.h"
#include "server/mechanics/scene/body.h"
#include "server/mechanics/scene/levels.h"

namespace tenter::mechanics {

struct SetUp {
  Boundary boundary;
  std::vector<Obstacle> obstacles;
  State start;  ///< with the noise, clips in the middle of their nodes
  std::vector<std::vector<int>> weight_nodes;
  std::vector<std::vector<int>> force_nodes;
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
};

/// bad_input begins with the path of the key of the scene: a selection without nodes, a node in two
/// clips, a free clip whose turn nothing determines, a pressure on a surface whose rim is not held.
Expected<SetUp> make_set_up(const scene::Scene& scene, const SceneBody& body);

/// Weights hang at their nodes in equal parts, forces the same.
Loads loads_at(const SetUp& set_up, const SceneBody& body, const Levels& levels);

/// The obstacles where they are at these levels.
std::vector<Obstacle> obstacles_at(const SetUp& set_up, const Levels& levels);

/// What a pressure really pushes with at the nodes of the surface's rim, minus what the potential
/// of conditions/loads.h says there (it closes the surface over the origin): 3 numbers a node (N),
/// zero elsewhere. Reactions of clips are to be corrected by it.
Eigen::VectorXd rim_force_N(const Boundary& boundary, double pressure_Pa, const Eigen::VectorXd& x);

}  // namespace tenter::mechanics
