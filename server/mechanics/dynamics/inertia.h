// SPDX-License-Identifier: GPL-3.0-or-later
// The inertia of a time step as an energy of positions, with lumped masses:
//
//   1/(2 h^2) sum_points m |x - x~|^2        h, x~: time_scheme.h
//
// Points of prescribed clips and held nodes count too: their forces are what the holder feels.
//
// A value; const members are callable from any thread; nothing allocates once it has its sizes.
#pragma once

#include "server/mechanics/conditions/node_energy.h"
#include "server/mechanics/dynamics/time_scheme.h"

namespace tenter::mechanics {

class Inertia final : public NodeEnergy {
 public:
  /// `node_mass_kg`: one a node; clips have their own.
  void set(const Boundary& boundary, const Eigen::VectorXd& node_mass_kg, const StepStart& start);

  void add(const Eigen::VectorXd& x, const LoadOutput& output,
           double positive_share) const override;
  const std::vector<ClipSpring>& clip_springs() const override { return clip_springs_; }

 private:
  Eigen::VectorXd stiffness_N_m_;  ///< m/h^2 of each node
  Eigen::VectorXd target_m_;
  std::vector<ClipSpring> clip_springs_;
};

}  // namespace tenter::mechanics
