// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/scene/set_up.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <utility>

namespace tenter::mechanics {
namespace {

std::string at(const std::string& list, std::size_t index) {
  return list + "[" + std::to_string(index) + "]";
}

tl::unexpected<Error> about(const std::string& path, const Error& error) {
  return fail(error.kind, path + ": " + error.message);
}

/// Edges that one triangle alone has, from end to end.
std::vector<std::pair<int, int>> rim(const std::vector<std::array<int, 3>>& triangles) {
  std::map<std::pair<int, int>, int> sides;
  for (const auto& t : triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const int from = t[c], to = t[(c + 1) % 3];
      ++sides[{std::min(from, to), std::max(from, to)}];
    }
  std::vector<std::pair<int, int>> result;
  for (const auto& [side, count] : sides)
    if (count == 1) result.push_back(side);
  return result;
}

Expected<void> add_clip(const scene::Clip& from, const SceneBody& body, SetUp& set_up) {
  const auto nodes = select(from.nodes, body);
  if (!nodes) return tl::unexpected(nodes.error());
  Pose pose;
  for (const int node : *nodes)
    pose.position_m += body.start_x.segment<3>(3 * node) / static_cast<double>(nodes->size());
  Clip clip = clip_on(from.id, *nodes, body.start_x, pose);
  clip.is_free = from.is_free;
  clip.mass_kg = from.mass_kg;
  clip.centre_of_mass_m = vector3(from.centre_of_mass_m);
  for (const scene::Cord& cord : from.cords) clip.cord_place_m.push_back(vector3(cord.at_m));
  set_up.boundary.clips.push_back(std::move(clip));
  set_up.start.clips.push_back(pose);
  return {};
}

Obstacle obstacle_of(const scene::Obstacle& from) {
  if (const auto* plane = std::get_if<scene::PlaneObstacle>(&from))
    return Plane{vector3(plane->point_m), vector3(plane->normal).normalized()};
  if (const auto* sphere = std::get_if<scene::SphereObstacle>(&from))
    return Sphere{vector3(sphere->point_m), sphere->radius_m};
  const auto& cylinder = std::get<scene::CylinderObstacle>(from);
  return Cylinder{vector3(cylinder.point_m), vector3(cylinder.axis).normalized(),
                  cylinder.radius_m};
}

/// Nodes off their places: of a sheet in the plane across it, of a body every way.
void add_noise(const scene::Start& start, const SceneBody& body, SetUp& set_up) {
  std::vector<bool> is_held(static_cast<std::size_t>(body.node_count()), false);
  for (const Clip& clip : set_up.boundary.clips)
    for (const int node : clip.nodes) is_held[static_cast<std::size_t>(node)] = true;
  std::mt19937 random(start.seed);
  for (int node = 0; node < body.node_count(); ++node)
    for (int axis = 0; axis < 3; ++axis) {
      const bool across = start.place == scene::Start::Place::vertical     ? axis == 1
                          : start.place == scene::Start::Place::horizontal ? axis == 2
                                                                           : true;
      if (!across) continue;
      // drawn for held nodes too: what is held does not change where the others start
      const double unit = static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
      if (!is_held[static_cast<std::size_t>(node)])
        set_up.start.x[3 * node + axis] += start.noise_m * (2.0 * unit - 1.0);
    }
}

Expected<void> add_pressure(const scene::Scene& scene, const SceneBody& body, SetUp& set_up) {
  const auto nodes = select(scene.pressure->nodes, body);
  if (!nodes) return about("pressure.nodes", nodes.error());
  set_up.boundary.pressed = pressed_surface(body, *nodes);
  if (set_up.boundary.pressed.empty())
    return bad_input("pressure.nodes: no triangle or face of the surface has only chosen nodes");
  std::vector<bool> is_held(static_cast<std::size_t>(body.node_count()), false);
  for (const Clip& clip : set_up.boundary.clips)
    if (!clip.is_free)
      for (const int node : clip.nodes) is_held[static_cast<std::size_t>(node)] = true;
  for (const auto& [a, b] : rim(set_up.boundary.pressed))
    for (const int node : {a, b})
      if (!is_held[static_cast<std::size_t>(node)])
        return bad_input("pressure: the surface is open at node " + std::to_string(node) +
                         ", which no clip holds: a pressure acts on a closed surface, or on one "
                         "whose whole rim is held");
  return {};
}

}  // namespace

Expected<SetUp> make_set_up(const scene::Scene& scene, const SceneBody& body) {
  SetUp set_up;
  set_up.gravity_m_s2 = vector3(scene.gravity_m_s2);
  set_up.start.x = body.start_x;
  for (std::size_t i = 0; i < scene.clips.size(); ++i)
    if (auto ok = add_clip(scene.clips[i], body, set_up); !ok)
      return about(at("clips", i) + ".nodes", ok.error());
  if (auto ok = check(set_up.boundary, body.node_count()); !ok) return about("clips", ok.error());
  for (const scene::Obstacle& obstacle : scene.obstacles)
    set_up.obstacles.push_back(obstacle_of(obstacle));
  for (std::size_t i = 0; i < scene.weights.size(); ++i) {
    auto nodes = select(scene.weights[i].nodes, body);
    if (!nodes) return about(at("weights", i) + ".nodes", nodes.error());
    set_up.weight_nodes.push_back(std::move(*nodes));
  }
  for (std::size_t i = 0; i < scene.forces.size(); ++i) {
    auto nodes = select(scene.forces[i].nodes, body);
    if (!nodes) return about(at("forces", i) + ".nodes", nodes.error());
    set_up.force_nodes.push_back(std::move(*nodes));
  }
  if (scene.pressure)
    if (auto ok = add_pressure(scene, body, set_up); !ok) return tl::unexpected(ok.error());
  add_noise(scene.start, body, set_up);
  return set_up;
}

Loads loads_at(const SetUp& set_up, const SceneBody& body, const Levels& levels) {
  Loads loads;
  loads.gravity_m_s2 = levels.gravity_factor * set_up.gravity_m_s2;
  loads.node_mass_kg = body.node_mass_kg;
  for (std::size_t i = 0; i < set_up.weight_nodes.size(); ++i) {
    const std::vector<int>& nodes = set_up.weight_nodes[i];
    for (const int node : nodes)
      loads.node_mass_kg[node] += levels.weight_kg[i] / static_cast<double>(nodes.size());
  }
  if (!set_up.force_nodes.empty())
    loads.node_force_N = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(body.node_count()));
  for (std::size_t i = 0; i < set_up.force_nodes.size(); ++i) {
    const std::vector<int>& nodes = set_up.force_nodes[i];
    for (const int node : nodes)
      loads.node_force_N.segment<3>(3 * node) +=
          levels.force_N[i] / static_cast<double>(nodes.size());
  }
  loads.cord_force_N = levels.cord_force_N;
  loads.pressure_Pa = levels.pressure_Pa;
  return loads;
}

std::vector<Obstacle> obstacles_at(const SetUp& set_up, const Levels& levels) {
  std::vector<Obstacle> moved = set_up.obstacles;
  for (std::size_t i = 0; i < moved.size(); ++i)
    std::visit([&](auto& shape) { shape.point_m += levels.obstacle_move_m[i]; }, moved[i]);
  return moved;
}

Eigen::VectorXd rim_force_N(const Boundary& boundary, double pressure_Pa,
                            const Eigen::VectorXd& x) {
  // a triangle's push p n A goes to its corners in thirds; the potential gives corner 0 the force
  // p x_1 x x_2 / 6, which sums to the same only where the triangles around a node close
  Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
  if (pressure_Pa == 0.0) return force;
  std::vector<bool> on_rim(static_cast<std::size_t>(x.size() / 3), false);
  for (const auto& [a, b] : rim(boundary.pressed)) {
    on_rim[static_cast<std::size_t>(a)] = true;
    on_rim[static_cast<std::size_t>(b)] = true;
  }
  for (const auto& t : boundary.pressed) {
    const Eigen::Vector3d p[3] = {x.segment<3>(3 * t[0]), x.segment<3>(3 * t[1]),
                                  x.segment<3>(3 * t[2])};
    const Eigen::Vector3d third = (p[1] - p[0]).cross(p[2] - p[0]) / 6.0;
    for (std::size_t c = 0; c < 3; ++c)
      if (on_rim[static_cast<std::size_t>(t[c])])
        force.segment<3>(3 * t[c]) +=
            pressure_Pa * (third - p[(c + 1) % 3].cross(p[(c + 2) % 3]) / 6.0);
  }
  return force;
}

}  // namespace tenter::mechanics
