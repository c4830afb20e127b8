// SPDX-License-Identifier: GPL-3.0-or-later
// The potential energy that equilibrium minimises: model, loads and contact over the unknowns.
//
//   Pi(x) = E(x, p) + V(x) + contact + energy limits + inertia of a time step
//
// With a history, E is the energy of the step from there.
//
//   const Potential potential(model, parameters, boundary, unknowns, loads, contact);
//   if (!potential.evaluate_with_stiffness(state, 0.0, value)) ...   // not finite: do not use
//
// Holds references to what it is made of. Callable from any thread; nothing allocates after the
// first call with the same value.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/mechanics/assembly/mesh_model.h"
#include "server/mechanics/conditions/boundary.h"
#include "server/mechanics/conditions/contact.h"
#include "server/mechanics/conditions/loads.h"
#include "server/mechanics/conditions/node_energy.h"
#include "server/mechanics/conditions/unknowns.h"

namespace tenter::mechanics {

struct PotentialValue {
  double energy_J = 0.0;
  double energy_size_J = 0.0;  ///< magnitudes of its addends: what its rounding is a part of
  Eigen::VectorXd by_node;     ///< dPi/dx over all nodes, N
  Eigen::VectorXd by_unknown;  ///< the same over the unknowns
  double net_force_N = 0.0;    ///< 2-norm over what is free
  bool has_stiffness = false;
  double positive_share = 0.0;    ///< of the stiffness below
  NodeMatrix node_stiffness;      ///< over all nodes
  std::vector<double> stiffness;  ///< values of the unknowns' pattern
};

class Potential {
 public:
  Potential(const MeshModel& model, const Eigen::VectorXd& parameters, const Boundary& boundary,
            const Unknowns& unknowns, const Loads& loads, const Contact& contact,
            const EnergyLimitState* limits = nullptr, const History* history = nullptr,
            NodeEnergy* inertia = nullptr);

  const MeshModel& model;
  const Eigen::VectorXd& parameters;
  const Boundary& boundary;
  const Unknowns& unknowns;
  const Loads& loads;
  const Contact& contact;
  const EnergyLimitState* limits;  ///< null: the model's energy limits are not enforced
  const History* history;          ///< null: as never strained before
  NodeEnergy* inertia;             ///< of a time step, or more of its kind; null: equilibrium

  /// False where the energy or a derivative is not finite.
  [[nodiscard]] bool evaluate(const State& state, PotentialValue& value) const;
  /// `positive_share`: from 0 (exact second derivative) to 1 (only what is never negative), see
  /// ModelOutput.
  [[nodiscard]] bool evaluate_with_stiffness(const State& state, double positive_share,
                                             PotentialValue& value) const;
  /// How much of the way a step of a minimisation may go (node_energy.h).
  double longest_fraction(const State& from, const State& to) const {
    return inertia ? inertia->longest_fraction(from.x, to.x) : 1.0;
  }
  /// Energy alone (J); not finite where the model has none.
  double energy_J(const State& state) const;

 private:
  bool evaluate(const State& state, const ModelOutput& wanted, PotentialValue& value) const;
  /// Energy of free clips (J), with its magnitudes added to `size`.
  double clip_energy_J(const State& state, double& size) const;
};

}  // namespace tenter::mechanics
