// SPDX-License-Identifier: GPL-3.0-or-later
// Addends that stiffen what is there (thesis 4.2, table 4.1 lists cross-modal stiffening):
//
//   cross_modal    Psi = c/2 eps_1^2 eps_2^2: each of two strains stiffens against the other, and
//                  nothing happens while either is zero
//   strain_limit   Psi = k/2 max(0, |eps| - limit)^2 of each strain: nothing below the limit,
//                  stiffness k more beyond it; convex, its tangent jumps at the limit
//
// Units of a membrane: c and k in N/m, limit as the strain. Stateless; from any thread.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class CrossModalLaw final : public Law {
 public:
  CrossModalLaw() : Law(2, 1, 0) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

class StrainLimitLaw final : public Law {
 public:
  explicit StrainLimitLaw(int strains) : Law(strains, 2, 0) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

}  // namespace tenter::mechanics
