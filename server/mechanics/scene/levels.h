// SPDX-License-Identifier: GPL-3.0-or-later
// What the protocol of a scene changes, at one moment: where prescribed clips are, how hard cords
// and forces pull, what weights weigh, gravity, pressure.
//
//   Levels levels = first_levels(scene, poses);
//   for (const scene::Phase& phase : scene.protocol) {
//     use(levels_in(scene, phase, levels, 0.5));       // half way through the phase
//     levels = levels_in(scene, phase, levels, 1.0);
//   }
//
// Values; pure functions.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/scene/scene.h"
#include "server/mechanics/conditions/boundary.h"

namespace tenter::mechanics {

struct Levels {
  std::vector<Pose> clips;  ///< of every clip; a free one's is where it was at the start
  std::vector<std::vector<Eigen::Vector3d>> cord_force_N;  ///< [clip][cord]
  std::vector<double> weight_kg;                           ///< as scene.weights
  std::vector<Eigen::Vector3d> force_N;                    ///< as scene.forces
  std::vector<Eigen::Vector3d> obstacle_move_m;            ///< since the start, as scene.obstacles
  double gravity_factor = 1.0;
  double pressure_Pa = 0.0;
};

/// What the scene begins with; `poses` are those of its clips.
Levels first_levels(const scene::Scene& scene, std::vector<Pose> poses);

/// The same with a share of everything that pulls or presses: 0 is without any load.
Levels loaded_in_part(const Levels& levels, double share);

/// After a share of a phase that began at `from`. Every motion moves its clip by that share of
/// move_m and then turns it by that share of turn_rad about its point; the rest goes linearly to
/// the phase's values. The scene has passed validate().
Levels levels_in(const scene::Scene& scene, const scene::Phase& phase, const Levels& from,
                 double share);

}  // namespace tenter::mechanics
