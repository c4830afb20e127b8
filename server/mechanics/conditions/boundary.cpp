// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/conditions/boundary.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace tenter::mechanics {
namespace {

bool lie_on_a_line(const std::vector<Eigen::Vector3d>& places) {
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : places)
    if ((p - places[0]).norm() > along.norm()) along = p - places[0];
  double off = 0.0;
  for (const Eigen::Vector3d& p : places) off = std::max(off, (p - places[0]).cross(along).norm());
  constexpr double kFlattest = 1e-9;  // of the length squared: below it a turn moves nothing
  return off <= kFlattest * along.squaredNorm();
}

bool is_rotation(const Eigen::Matrix3d& r) {
  constexpr double kOff = 1e-6;  // a file's digits are enough; a scale or a mirror is not let by
  return r.allFinite() && (r.transpose() * r).isIdentity(kOff) && r.determinant() > 0.0;
}

}  // namespace

Expected<void> check(const Boundary& boundary, int node_count) {
  std::vector<bool> taken(static_cast<std::size_t>(node_count), false);
  const auto take = [&](int node, const std::string& by) -> Expected<void> {
    if (node < 0 || node >= node_count)
      return bad_input(by + " holds node " + std::to_string(node) + ", of which there are " +
                       std::to_string(node_count));
    if (taken[static_cast<std::size_t>(node)])
      return bad_input(by + " holds node " + std::to_string(node) + ", which is held already");
    taken[static_cast<std::size_t>(node)] = true;
    return {};
  };
  for (const int node : boundary.held)
    if (auto ok = take(node, "the list of held nodes"); !ok) return ok;
  for (const Clip& clip : boundary.clips) {
    const std::string name = "clip \"" + clip.id + "\"";
    if (clip.nodes.empty()) return bad_input(name + " holds no node");
    if (clip.place_m.size() != clip.nodes.size())
      return bad_input(name + " has " + std::to_string(clip.place_m.size()) + " places for " +
                       std::to_string(clip.nodes.size()) + " nodes");
    for (const int node : clip.nodes)
      if (auto ok = take(node, name); !ok) return ok;
    std::vector<Eigen::Vector3d> places = clip.place_m;
    places.insert(places.end(), clip.cord_place_m.begin(), clip.cord_place_m.end());
    for (const Eigen::Vector3d& place : places)
      if (!place.allFinite()) return bad_input(name + " has a place that is no number");
    if (!std::isfinite(clip.mass_kg) || clip.mass_kg < 0.0 || !clip.centre_of_mass_m.allFinite())
      return bad_input(name + " has no proper mass or centre of mass");
    if (clip.mass_kg > 0.0) places.push_back(clip.centre_of_mass_m);
    if (clip.is_free && lie_on_a_line(places))
      return bad_input(name +
                       " is free, but its nodes, cords and weight lie on one line: nothing "
                       "determines its turn about it");
  }
  for (const auto& triangle : boundary.pressed)
    for (const int node : triangle)
      if (node < 0 || node >= node_count)
        return bad_input("the pressed surface has node " + std::to_string(node) +
                         ", of which there are " + std::to_string(node_count));
  return {};
}

Expected<void> check(const State& state, const Boundary& boundary, int node_count) {
  if (state.x.size() != 3 * static_cast<Eigen::Index>(node_count))
    return bad_input("the mesh has " + std::to_string(node_count) +
                     " nodes, positions are given for " + std::to_string(state.x.size() / 3));
  if (!state.x.allFinite()) return bad_input("a position is no number");
  if (state.clips.size() != boundary.clips.size())
    return bad_input("there are " + std::to_string(boundary.clips.size()) +
                     " clips, poses are given for " + std::to_string(state.clips.size()));
  for (std::size_t c = 0; c < state.clips.size(); ++c)
    if (!is_rotation(state.clips[c].rotation) || !state.clips[c].position_m.allFinite())
      return bad_input("the pose of clip \"" + boundary.clips[c].id +
                       "\" is no rotation and position");
  return {};
}

Clip clip_on(std::string id, std::vector<int> nodes, const Eigen::VectorXd& x, const Pose& pose) {
  Clip clip;
  clip.id = std::move(id);
  clip.nodes = std::move(nodes);
  for (const int node : clip.nodes)
    clip.place_m.emplace_back(pose.rotation.transpose() *
                              (x.segment<3>(3 * node) - pose.position_m));
  return clip;
}

void place_clips(const Boundary& boundary, State& state) {
  for (std::size_t c = 0; c < boundary.clips.size(); ++c) {
    const Clip& clip = boundary.clips[c];
    for (std::size_t i = 0; i < clip.nodes.size(); ++i)
      state.x.segment<3>(3 * clip.nodes[i]) = state.clips[c].to_space(clip.place_m[i]);
  }
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

}  // namespace tenter::mechanics
