// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/scene/levels.h"

#include <algorithm>
#include <string>
#include <utility>

#include "server/mechanics/scene/body.h"

namespace tenter::mechanics {
namespace {

/// Ids are known: validate() has seen to it.
template <class List>
std::size_t index_of(const List& list, const std::string& id) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&id](const auto& entry) { return entry.id == id; });
  return static_cast<std::size_t>(found - list.begin());
}

void apply(const scene::Motion& motion, double share, Pose& pose) {
  pose.position_m += share * vector3(motion.move_m);
  const Eigen::Matrix3d turn = rotation_of(share * vector3(motion.turn_rad));
  const Eigen::Vector3d about = motion.about_m ? vector3(*motion.about_m) : pose.position_m;
  pose.position_m = about + turn * (pose.position_m - about);
  pose.rotation = turn * pose.rotation;
}

}  // namespace

Levels first_levels(const scene::Scene& scene, std::vector<Pose> poses) {
  Levels levels;
  levels.clips = std::move(poses);
  for (const scene::Clip& clip : scene.clips) {
    auto& forces = levels.cord_force_N.emplace_back();
    for (const scene::Cord& cord : clip.cords) forces.push_back(vector3(cord.force_N));
  }
  for (const scene::Weight& weight : scene.weights) levels.weight_kg.push_back(weight.mass_kg);
  for (const scene::Force& force : scene.forces) levels.force_N.push_back(vector3(force.force_N));
  levels.obstacle_move_m.assign(scene.obstacles.size(), Eigen::Vector3d::Zero());
  levels.gravity_factor = scene.start.gravity_factor;
  levels.pressure_Pa = scene.pressure ? scene.pressure->pressure_Pa : 0.0;
  return levels;
}

Levels loaded_in_part(const Levels& levels, double share) {
  Levels part = levels;
  for (auto& clip : part.cord_force_N)
    for (Eigen::Vector3d& force : clip) force *= share;
  for (Eigen::Vector3d& force : part.force_N) force *= share;
  part.gravity_factor *= share;
  part.pressure_Pa *= share;
  return part;
}

Levels levels_in(const scene::Scene& scene, const scene::Phase& phase, const Levels& from,
                 double share) {
  const auto towards = [share](const auto& begin, const auto& end) {
    return ((1.0 - share) * begin + share * end);
  };
  Levels levels = from;
  for (const scene::Motion& motion : phase.motions)
    apply(motion, share, levels.clips[index_of(scene.clips, motion.clip)]);
  for (const scene::CordForce& pull : phase.cords) {
    const std::size_t clip = index_of(scene.clips, pull.clip);
    Eigen::Vector3d& force =
        levels.cord_force_N[clip][index_of(scene.clips[clip].cords, pull.cord)];
    force = towards(force, vector3(pull.force_N)).eval();
  }
  for (const scene::WeightMass& hang : phase.weights) {
    double& mass = levels.weight_kg[index_of(scene.weights, hang.weight)];
    mass = towards(mass, hang.mass_kg);
  }
  for (const scene::ForceValue& push : phase.forces) {
    Eigen::Vector3d& force = levels.force_N[index_of(scene.forces, push.force)];
    force = towards(force, vector3(push.force_N)).eval();
  }
  for (const scene::ObstacleMotion& motion : phase.obstacles)
    levels.obstacle_move_m[static_cast<std::size_t>(motion.obstacle)] +=
        share * vector3(motion.move_m);
  if (phase.gravity_factor)
    levels.gravity_factor = towards(from.gravity_factor, *phase.gravity_factor);
  if (phase.pressure_Pa) levels.pressure_Pa = towards(from.pressure_Pa, *phase.pressure_Pa);
  return levels;
}

}  // namespace tenter::mechanics
