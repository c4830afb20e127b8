// SPDX-License-Identifier: GPL-3.0-or-later
// Contact and energy limits by rounds of minimisation: between two rounds the multipliers take over
// what the penalties held, until both conditions hold as closely as asked.
//
//   rounds.start(model, contact, penalty);      // or keep the multipliers of the step before
//   do { minimise(potential with rounds.contact(), rounds.limits()); }
//   while (!rounds.are_met(...) && rounds.press_harder(...));
//
// Belongs to one thread at a time.
#pragma once

#include <limits>
#include <vector>

#include "server/mechanics/assembly/mesh_model.h"
#include "server/mechanics/conditions/contact.h"

namespace tenter::mechanics {

struct ConstraintTolerance {
  double contact_depth_m = 1e-6;
  double limit = 1e-6;  ///< in parts of psi_max
};

struct Violation {
  double contact_m = 0.0;
  double limit = 0.0;  ///< in parts of psi_max; infinite where the model has no energy

  bool is_within(const ConstraintTolerance& tolerance) const {
    return contact_m <= tolerance.contact_depth_m && limit <= tolerance.limit;
  }
};

class ConstraintRounds {
 public:
  /// Multipliers at zero; `contact` as made. The penalty of limits is on the scale of what they
  /// hold against.
  void start(const MeshModel& model, Contact contact);

  const Contact& contact() const { return contact_; }
  Contact& contact() { return contact_; }
  const EnergyLimitState& limits() const { return limits_; }

  Violation violation(const MeshModel& model, const Eigen::VectorXd& parameters,
                      const Eigen::VectorXd& x) const;

  /// New multipliers, and higher penalties where the violation shrank slowly since `before`.
  void press_harder(const MeshModel& model, const Eigen::VectorXd& parameters,
                    const Eigen::VectorXd& x, const ConstraintTolerance& tolerance,
                    const Violation& before, const Violation& now);

 private:
  Contact contact_;
  EnergyLimitState limits_;
};

}  // namespace tenter::mechanics
