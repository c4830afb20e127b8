// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/conditions/potential.h"

#include <cmath>
#include <limits>

namespace tenter::mechanics {

Potential::Potential(const MeshModel& of_model, const Eigen::VectorXd& at_parameters,
                     const Boundary& of_boundary, const Unknowns& of_unknowns,
                     const Loads& of_loads, const Contact& of_contact,
                     const EnergyLimitState* of_limits, const History* from_history,
                     NodeEnergy* of_inertia)
    : model(of_model),
      parameters(at_parameters),
      boundary(of_boundary),
      unknowns(of_unknowns),
      loads(of_loads),
      contact(of_contact),
      limits(of_limits),
      history(from_history),
      inertia(of_inertia) {}

bool Potential::evaluate(const State& state, PotentialValue& value) const {
  return evaluate(state, ModelOutput{&value.energy_J, &value.by_node}, value);
}

bool Potential::evaluate_with_stiffness(const State& state, double positive_share,
                                        PotentialValue& value) const {
  if (value.node_stiffness.node_count() != model.node_count())
    value.node_stiffness = model.matrix();
  ModelOutput wanted{&value.energy_J, &value.by_node, &value.node_stiffness};
  wanted.positive_share = positive_share;
  if (!evaluate(state, wanted, value)) return false;
  unknowns.reduce_matrix(loads, state, value.by_node, value.node_stiffness, positive_share,
                         value.stiffness);
  if (inertia)
    for (const ClipSpring& spring : inertia->clip_springs())
      unknowns.add_spring_stiffness(spring, state, positive_share, value.stiffness);
  return true;
}

bool Potential::evaluate(const State& state, const ModelOutput& wanted,
                         PotentialValue& value) const {
  value.has_stiffness = wanted.stiffness != nullptr;
  value.positive_share = wanted.positive_share;
  if (model.evaluate(state.x, parameters, wanted, limits, history) != AssemblyStatus::ok)
    return false;
  value.energy_size_J = std::abs(value.energy_J);
  const LoadOutput output{&value.energy_J, value.by_node.data(), wanted.stiffness,
                          &value.energy_size_J};
  add_loads(loads, boundary, state.x, output);
  contact.add(state.x, output, wanted.positive_share);
  if (inertia) inertia->add(state.x, output, wanted.positive_share);
  value.energy_J += clip_energy_J(state, value.energy_size_J);
  unknowns.reduce_gradient(loads, state, value.by_node, value.by_unknown);
  if (inertia)
    for (const ClipSpring& spring : inertia->clip_springs())
      unknowns.add_spring_gradient(spring, state, value.by_unknown);
  value.net_force_N = unknowns.net_force_N(value.by_unknown);
  return std::isfinite(value.energy_J) && std::isfinite(value.net_force_N);
}

double Potential::energy_J(const State& state) const {
  double energy = 0.0;
  ModelOutput wanted;
  wanted.energy = &energy;
  if (model.evaluate(state.x, parameters, wanted, limits, history) != AssemblyStatus::ok)
    return std::numeric_limits<double>::infinity();
  const LoadOutput output{&energy, nullptr, nullptr, nullptr};
  add_loads(loads, boundary, state.x, output);
  contact.add(state.x, output, 0.0);
  if (inertia) inertia->add(state.x, output, 0.0);
  double size = 0.0;
  energy += clip_energy_J(state, size);
  return std::isnan(energy) ? std::numeric_limits<double>::infinity() : energy;
}

double Potential::clip_energy_J(const State& state, double& size) const {
  double sum = 0.0;
  const auto count = [&](double energy) {
    sum += energy;
    size += std::abs(energy);
  };
  for (std::size_t c = 0; c < boundary.clips.size(); ++c)
    if (boundary.clips[c].is_free)
      count(clip_potential_J(loads, boundary, static_cast<int>(c), state.clips[c]));
  if (!inertia) return sum;
  for (const ClipSpring& spring : inertia->clip_springs()) {
    const Pose& pose = state.clips[static_cast<std::size_t>(spring.clip)];
    count(0.5 * spring.stiffness_N_m *
          (pose.to_space(spring.place_m) - spring.target_m).squaredNorm());
  }
  return sum;
}

}  // namespace tenter::mechanics
