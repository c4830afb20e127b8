// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/observations.h"

#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <string>

#include "server/estimation/sequences/material/material_locator.h"

namespace tenter::estimation {

using mechanics::Clip;

namespace {

/// What channels are checked against.
struct Subject {
  const Sequence& sequence;
  const MaterialLocator& locator;
};

bool is_unit(const Eigen::Vector3d& v) {
  constexpr double kOff = 1e-9;
  return std::abs(v.norm() - 1.0) < kOff;
}

Expected<void> check_sigma(double sigma) {
  if (sigma > 0.0 && std::isfinite(sigma)) return {};
  return bad_input(" has no standard deviation above zero");
}

Expected<void> check_clip(const Subject& subject, int clip, bool may_be_free) {
  if (clip < 0 || clip >= static_cast<int>(subject.sequence.boundaries.front().clips.size()))
    return bad_input(" is of clip " + std::to_string(clip) + ", which there is not");
  for (const mechanics::Boundary& boundary : subject.sequence.boundaries)
    if (!may_be_free && boundary.clips[static_cast<std::size_t>(clip)].is_free)
      return bad_input(" is of a free clip, on which only its known cords act");
  return {};
}

Expected<void> check_channel(const Subject& subject, const PointChannel& point) {
  if (!subject.locator.locate(point.material_m)) return bad_input(" lies outside of the mesh");
  return check_sigma(point.sigma_m);
}

Expected<void> check_channel(const Subject& subject, const ForceChannel& force) {
  if (auto ok = check_clip(subject, force.clip, !force.turns_with_clip); !ok) return ok;
  if (!is_unit(force.direction)) return bad_input(" has a direction that is not of length one");
  return check_sigma(force.sigma_N);
}

Expected<void> check_channel(const Subject& subject, const TorqueChannel& torque) {
  if (torque.clips.empty()) return bad_input(" is a torque of no clip");
  for (const TorqueChannel::Share& share : torque.clips) {
    if (auto ok = check_clip(subject, share.clip, false); !ok) return ok;
    if (!std::isfinite(share.factor)) return bad_input(" has a factor that is no number");
  }
  if (!is_unit(torque.axis)) return bad_input(" has an axis that is not of length one");
  if (!torque.about_m.allFinite()) return bad_input(" is about a point that is none");
  return check_sigma(torque.sigma_N_m);
}

Expected<void> check_channel(const Subject& subject, const LengthChannel& length) {
  for (const Eigen::Vector2d& end : {length.from_m, length.to_m})
    if (!subject.locator.locate(end)) return bad_input(" ends outside of the mesh");
  if (length.from_m == length.to_m) return bad_input(" is between a point and itself");
  return check_sigma(length.sigma_m);
}

Expected<void> check_channel(const Subject&, const AreaChannel& area) {
  return check_sigma(area.sigma_m2);
}

Expected<void> check_channel(const Subject& subject, const ScalarChannel& scalar) {
  return std::visit([&](const auto& channel) { return check_channel(subject, channel); }, scalar);
}

template <class Channels>
Expected<void> check_all(const Subject& subject, const char* kind, const Channels& channels) {
  for (std::size_t k = 0; k < channels.size(); ++k)
    if (auto ok = check_channel(subject, channels[k]); !ok)
      return bad_input(kind + std::to_string(k + 1) + ok.error().message);
  return {};
}

double sigma_of(const TorqueChannel& torque) {
  return torque.sigma_N_m;
}
double sigma_of(const LengthChannel& length) {
  return length.sigma_m;
}
double sigma_of(const AreaChannel& area) {
  return area.sigma_m2;
}

void observe(const MaterialLocation& place, int component, const RestState& at, Observation& seen) {
  seen.value = place.position(at.state.x)[component];
  for (std::size_t a = 0; a < 3; ++a)
    if (place.weight[a] != 0.0)
      seen.by_x.push_back({place.nodes[a], place.weight[a] * Eigen::Vector3d::Unit(component)});
}

/// The holder bears what the cloth pulls and what the clip weighs: with pull = -sum G_i,
///
///   F = d . (sum G_i - m g)
void observe(const Sequence& sequence, const ForceChannel& force, const RestState& at,
             Observation& seen) {
  const auto c = static_cast<std::size_t>(force.clip);
  const Clip& clip = at.boundary.clips[c];
  const Eigen::Vector3d d = force.turns_with_clip
                                ? Eigen::Vector3d(at.state.clips[c].rotation * force.direction)
                                : force.direction;
  seen.value = -clip.mass_kg * d.dot(sequence.loads.gravity_m_s2);
  for (const int node : clip.nodes) {
    seen.value += d.dot(at.by_node.segment<3>(3 * static_cast<Eigen::Index>(node)));
    seen.by_gradient.push_back({node, d});
  }
}

/// T = a . sum_clips factor (sum_i (x_i - o) x G_i - (c - o) x m g)
void observe(const Sequence& sequence, const TorqueChannel& torque, const RestState& at,
             Observation& seen) {
  seen.value = 0.0;
  for (const TorqueChannel::Share& share : torque.clips) {
    const auto c = static_cast<std::size_t>(share.clip);
    const Clip& clip = at.boundary.clips[c];
    const Eigen::Vector3d axis = share.factor * torque.axis;
    const Eigen::Vector3d centre = at.state.clips[c].to_space(clip.centre_of_mass_m);
    seen.value -=
        axis.dot((centre - torque.about_m).cross(clip.mass_kg * sequence.loads.gravity_m_s2));
    for (const int node : clip.nodes) {
      const auto first = 3 * static_cast<Eigen::Index>(node);
      const Eigen::Vector3d arm = at.state.x.segment<3>(first) - torque.about_m;
      const Eigen::Vector3d g = at.by_node.segment<3>(first);
      seen.value += axis.dot(arm.cross(g));
      seen.by_x.push_back({node, g.cross(axis)});
      seen.by_gradient.push_back({node, axis.cross(arm)});
    }
  }
}

void observe(const MaterialLocation& from, const MaterialLocation& to, const RestState& at,
             Observation& seen) {
  const Eigen::Vector3d way = to.position(at.state.x) - from.position(at.state.x);
  seen.value = way.norm();
  const Eigen::Vector3d along = way / seen.value;
  for (std::size_t a = 0; a < 3; ++a) {
    seen.by_x.push_back({to.nodes[a], to.weight[a] * along});
    seen.by_x.push_back({from.nodes[a], -from.weight[a] * along});
  }
}

/// A = sum |n|/2, n = (x_1 - x_0) x (x_2 - x_0); dA/dx_a = (n/|n|) x (opposite edge)/2.
void observe_area(const mechanics::SurfaceMesh& mesh, const RestState& at, Observation& seen) {
  seen.value = 0.0;
  for (const auto& corners : mesh.triangles) {
    const auto place = [&](std::size_t a) -> Eigen::Vector3d {
      return at.state.x.segment<3>(3 * static_cast<Eigen::Index>(corners[a % 3]));
    };
    const Eigen::Vector3d n = (place(1) - place(0)).cross(place(2) - place(0));
    seen.value += 0.5 * n.norm();
    for (std::size_t a = 0; a < 3; ++a)
      seen.by_x.push_back({corners[a], 0.5 * n.normalized().cross(place(a + 2) - place(a + 1))});
  }
}

}  // namespace

Expected<void> check_channels(const Sequence& sequence) {
  if (sequence.cloth.mesh.triangle_count() == 0) return bad_input("the mesh has no triangle");
  const MaterialLocator locator(sequence.cloth.mesh);
  const Subject subject{sequence, locator};
  if (auto ok = check_all(subject, "point ", sequence.points); !ok) return ok;
  if (auto ok = check_all(subject, "force ", sequence.forces); !ok) return ok;
  std::set<std::string> names;
  for (const ForceChannel& force : sequence.forces)
    if (!force.name.empty() && !names.insert(force.name).second)
      return bad_input("two forces are called \"" + force.name + "\"");
  if (!is_unit(sequence.camera_axis)) return bad_input("the camera's axis is not of length one");
  return check_all(subject, "scalar ", sequence.scalars);
}

Observations::Observations(const Sequence& sequence)
    : first_force_(static_cast<int>(3 * sequence.points.size())),
      first_scalar_(first_force_ + static_cast<int>(sequence.forces.size())),
      count_(first_scalar_ + static_cast<int>(sequence.scalars.size())) {
  const MaterialLocator locator(sequence.cloth.mesh);
  const auto find = [&](const Eigen::Vector2d& material_m) {
    return locator.locate(material_m).value_or(MaterialLocation{});
  };
  for (const PointChannel& point : sequence.points) points_.push_back(find(point.material_m));
  for (const ScalarChannel& scalar : sequence.scalars) {
    const auto* length = std::get_if<LengthChannel>(&scalar);
    lengths_.emplace_back();
    if (length) lengths_.back() = {find(length->from_m), find(length->to_m)};
  }
}

double Observations::sigma(const Sequence& sequence, int channel) const {
  if (channel < first_force_) return sequence.points[static_cast<std::size_t>(channel / 3)].sigma_m;
  if (channel < first_scalar_)
    return sequence.forces[static_cast<std::size_t>(channel - first_force_)].sigma_N;
  return std::visit([](const auto& scalar) { return sigma_of(scalar); },
                    sequence.scalars[static_cast<std::size_t>(channel - first_scalar_)]);
}

ObservationKind Observations::kind(const Sequence& sequence, int channel) const {
  if (channel < first_force_) return ObservationKind::position;
  if (channel < first_scalar_) return ObservationKind::force;
  const auto k = static_cast<std::size_t>(channel - first_scalar_);
  return std::holds_alternative<LengthChannel>(sequence.scalars[k]) ? ObservationKind::position
                                                                    : ObservationKind::other;
}

double Observations::measured(const SequenceFrame& frame, int channel) const {
  if (channel < first_force_) return frame.points_m(channel % 3, channel / 3);
  if (channel < first_scalar_) return frame.forces_N[channel - first_force_];
  return frame.scalars[channel - first_scalar_];
}

void Observations::observe(const Sequence& sequence, int channel, const RestState& at,
                           Observation& seen) const {
  seen.by_x.clear();
  seen.by_gradient.clear();
  if (channel < first_force_) {
    estimation::observe(points_[static_cast<std::size_t>(channel / 3)], channel % 3, at, seen);
    return;
  }
  if (channel < first_scalar_) {
    const auto force = static_cast<std::size_t>(channel - first_force_);
    estimation::observe(sequence, sequence.forces[force], at, seen);
    return;
  }
  const auto k = static_cast<std::size_t>(channel - first_scalar_);
  const ScalarChannel& scalar = sequence.scalars[k];
  if (const auto* torque = std::get_if<TorqueChannel>(&scalar))
    estimation::observe(sequence, *torque, at, seen);
  else if (std::holds_alternative<LengthChannel>(scalar))
    estimation::observe(lengths_[k].first, lengths_[k].second, at, seen);
  else
    observe_area(sequence.cloth.mesh, at, seen);
}

void change_of(const Observation& seen, const mechanics::Sensitivity& by_parameter,
               Eigen::RowVectorXd& change) {
  change.setZero(by_parameter.x.cols());
  for (const Observation::ByNode& part : seen.by_x)
    change.noalias() += part.by.transpose() * by_parameter.x.middleRows<3>(3 * part.node);
  for (const Observation::ByNode& part : seen.by_gradient)
    change.noalias() += part.by.transpose() * by_parameter.gradient.middleRows<3>(3 * part.node);
}

}  // namespace tenter::estimation
