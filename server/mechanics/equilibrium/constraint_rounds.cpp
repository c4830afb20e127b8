// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/constraint_rounds.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tenter::mechanics {

void ConstraintRounds::start(const MeshModel& model, Contact contact) {
  contact_ = std::move(contact);
  limits_.multiplier.setZero(model.limited_count());
  limits_.penalty = 0.0;
  constexpr double kPenalty = 10.0;  // in 1/psi_max of the lowest limit
  for (const LimitedElements& limited : model.limited())
    limits_.penalty = std::max(limits_.penalty, kPenalty / limited.energy_max);
}

Violation ConstraintRounds::violation(const MeshModel& model, const Eigen::VectorXd& parameters,
                                      const Eigen::VectorXd& x) const {
  Violation result;
  result.contact_m = contact_.violation_m(x);
  if (model.limited_count() == 0) return result;
  Eigen::VectorXd excess;
  if (model.limit_excess(x, parameters, excess) != AssemblyStatus::ok) {
    result.limit = std::numeric_limits<double>::infinity();
    return result;
  }
  for (const LimitedElements& limited : model.limited()) {
    for (std::size_t e = 0; e < limited.element.size(); ++e) {
      const auto k = static_cast<Eigen::Index>(limited.first) + static_cast<Eigen::Index>(e);
      // too high, or below its limit and still held back
      const double off = std::max(excess[k], -limits_.multiplier[k] / limits_.penalty);
      result.limit = std::max(result.limit, std::abs(off) / limited.energy_max);
    }
  }
  return result;
}

void ConstraintRounds::press_harder(const MeshModel& model, const Eigen::VectorXd& parameters,
                                    const Eigen::VectorXd& x, const ConstraintTolerance& tolerance,
                                    const Violation& before, const Violation& now) {
  constexpr double kSlow = 0.3;  // violation after / before
  constexpr double kRaise = 4.0;
  if (now.contact_m > tolerance.contact_depth_m) {
    contact_.update_forces(x);
    if (before.contact_m > 0.0 && now.contact_m > kSlow * before.contact_m)
      contact_.raise_penalty(kRaise);
  }
  Eigen::VectorXd excess;
  if (now.limit > tolerance.limit &&
      model.limit_excess(x, parameters, excess) == AssemblyStatus::ok) {
    update_multipliers(excess, limits_);
    if (before.limit > 0.0 && now.limit > kSlow * before.limit) limits_.penalty *= kRaise;
  }
}

}  // namespace tenter::mechanics
