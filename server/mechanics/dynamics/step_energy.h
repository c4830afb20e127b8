// SPDX-License-Identifier: GPL-3.0-or-later
// What a time step adds to the energy of equilibrium: inertia, and the contact of a sheet with
// itself where it is asked for. One of conditions/node_energy.h made of two.
#pragma once

#include <optional>

#include "server/mechanics/contact/self_contact.h"
#include "server/mechanics/dynamics/inertia.h"

namespace tenter::mechanics {

struct StepEnergy final : public NodeEnergy {
  Inertia inertia;
  std::optional<SelfContact> self_contact;

  void add(const Eigen::VectorXd& x, const LoadOutput& output,
           double positive_share) const override {
    inertia.add(x, output, positive_share);
    if (self_contact) self_contact->add(x, output, positive_share);
  }
  double longest_fraction(const Eigen::VectorXd& from, const Eigen::VectorXd& to) override {
    return self_contact ? self_contact->longest_fraction(from, to) : 1.0;
  }
  const std::vector<ClipSpring>& clip_springs() const override { return inertia.clip_springs(); }
};

}  // namespace tenter::mechanics
