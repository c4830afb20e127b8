// SPDX-License-Identifier: GPL-3.0-or-later
// Dahl friction as the papers step it, to compare with dahl.h (thesis 5.9): within a step the
// stress is linear in the strain, with a stiffness from what was known before the step,
//
//   sigma = sigma0 + K (eps - eps0)
//   K = (sigma_max(eps0) - s0 sigma0 + sigma_max'(eps0) d0) / (tau + s0 d0)
//
// d0: the strain's increment in the step before (dt eps_dot0 of the thesis, for steps of equal
// length), s0 its sign, 0 where it was 0. At the end of the step the stress is set to the exact one
// of the path (dahl.h), as the thesis' algorithm does. A reversal is known one step late.
//
// Parameters a, b, c (N/m), tau (strain), as dahl; one strain. State: stress, last strain, last
// increment.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class LinearisedDahlLaw final : public Law {
 public:
  LinearisedDahlLaw() : Law(1, 4, 3) {}
  StateKind state_kind(int i) const override {
    return i == 1 ? StateKind::last_strain : StateKind::transient;
  }
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

}  // namespace tenter::mechanics
