// SPDX-License-Identifier: GPL-3.0-or-later
// Dahl friction on one strain measure (thesis 5.2):
//
//   d sigma / d eps = (sigma_max(eps) - s sigma) / tau,   s = sign(d eps),   sigma_max = a + b|eps|
//   + c eps^2
//
// solved exactly over a step of one-signed strain increment, split at eps = 0 where |eps| has its
// kink. Measures with two strains (fibre pairs) carry two independent friction stresses with the
// same parameters.
//
// Parameters a, b, c (N/m), tau (strain). State per strain: friction stress (N/m), strain at the
// end of the last step. Dissipation is non-negative where b tau <= 2 sigma_max (architecture.md);
// fits bound it, reports check it.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class DahlLaw final : public Law {
 public:
  explicit DahlLaw(int strains) : Law(strains, 4, 2 * strains) {}
  StateKind state_kind(int i) const override {
    return i % 2 == 0 ? StateKind::transient : StateKind::last_strain;
  }
  bool turns_round() const override { return true; }
  void evaluate(const LawInput& in, LawOutput& out) const override;
  void evaluate_batch(const double* parameters, const LawBatch& batch) const override;
};

/// Friction stress after going from strain e0 with stress s0 to e1, with derivatives; the kernel of
/// the law.
struct DahlStep {
  double stress = 0.0;
  double potential = 0.0;  ///< integral of the stress from e0 to e1 (N/m)
  double by_e1 = 0.0;      ///< tangent
  double by_e0 = 0.0;
  double by_s0 = 0.0;
  double by_parameter[4] = {};  ///< a, b, c, tau
};
DahlStep dahl_step(double e0, double s0, double e1, const double* parameters);

}  // namespace tenter::mechanics
