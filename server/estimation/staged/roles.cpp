// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/roles.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <string_view>

namespace tenter::estimation {
namespace {

/// The direction in space that a clip is long in: the principal axis of its nodes.
Eigen::Vector3d long_axis(const mechanics::Clip& clip, const mechanics::Pose& pose) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& place : clip.place_m)
    middle += place / static_cast<double>(clip.place_m.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& place : clip.place_m)
    spread += (place - middle) * (place - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
  return pose.rotation * eigen.eigenvectors().col(2);
}

/// Force channels along the clips that they are of; all where there is none.
std::vector<int> along_clips(const Sequence& sequence) {
  std::vector<int> along, all;
  const SequenceFrame& first = sequence.frames.front();
  const auto& clips = sequence.boundaries[static_cast<std::size_t>(first.boundary)].clips;
  for (std::size_t k = 0; k < sequence.forces.size(); ++k) {
    const ForceChannel& force = sequence.forces[k];
    const auto c = static_cast<std::size_t>(force.clip);
    all.push_back(static_cast<int>(k));
    const mechanics::Pose pose = force.turns_with_clip ? mechanics::Pose{} : first.clips[c];
    if (std::abs(force.direction.dot(long_axis(clips[c], pose))) > std::sqrt(0.5))
      along.push_back(static_cast<int>(k));
  }
  return along.empty() ? all : along;
}

}  // namespace

GapRows rows_of(Role role, Channels channels) {
  if (channels == Channels::all || role == Role::evaluation) return GapRows::all;
  return role == Role::bend_u || role == Role::bend_v ? GapRows::positions : GapRows::forces;
}

Sequence observed(const RoleSequence& measured, Channels channels) {
  Sequence result = measured.sequence;
  const GapRows rows = rows_of(measured.role, channels);
  if (rows != GapRows::all) {
    result.scalars.clear();
    for (SequenceFrame& frame : result.frames) frame.scalars.resize(0);
  }
  if (rows == GapRows::positions && !result.points.empty()) {
    result.forces.clear();
    for (SequenceFrame& frame : result.frames) frame.forces_N.resize(0);
  }
  if (rows == GapRows::forces && !result.forces.empty()) {
    result.points.clear();
    if (measured.role == Role::shear && !result.frames.empty()) {
      const std::vector<int> kept = along_clips(result);
      std::vector<ForceChannel> forces;
      forces.reserve(kept.size());
      for (const int k : kept) forces.push_back(result.forces[static_cast<std::size_t>(k)]);
      result.forces = std::move(forces);
      for (SequenceFrame& frame : result.frames)
        frame.forces_N = Eigen::VectorXd(frame.forces_N(kept));
    }
    for (SequenceFrame& frame : result.frames) frame.points_m.resize(3, 0);
  }
  return result;
}

std::optional<Component> component_of(const model::Term& term) {
  struct Known {
    std::string_view strain;
    Component component;
  };
  static constexpr Known kKnown[] = {
      {"green_u", Component::stretch_u},     {"soft_u", Component::stretch_u},
      {"spring_u", Component::stretch_u},    {"green_v", Component::stretch_v},
      {"soft_v", Component::stretch_v},      {"spring_v", Component::stretch_v},
      {"green_uv", Component::shear},        {"spring_d1", Component::shear},
      {"spring_d2", Component::shear},       {"bend_u", Component::bend_u},
      {"ring2_u", Component::bend_u},        {"bend_v", Component::bend_v},
      {"ring2_v", Component::bend_v},        {"bend_d", Component::bend_diagonal},
      {"ring2_d", Component::bend_diagonal},
  };
  for (const Known& known : kKnown)
    if (known.strain == term.strain.name) return known.component;
  return std::nullopt;
}

std::vector<std::string> terms_of(const model::Model& model, Component component) {
  std::vector<std::string> ids;
  for (const model::Term& term : model.terms)
    if (component_of(term) == component) ids.push_back(term.id);
  return ids;
}

}  // namespace tenter::estimation
