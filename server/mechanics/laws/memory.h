// SPDX-License-Identifier: GPL-3.0-or-later
// Laws that remember the largest strain m that the material has seen (m grows on first loadings
// only).
//
//   plastic_set  sigma = -c max(0, m - y): the rest length moves with each new maximum beyond the
//   yield strain y, and
//                nothing but a new maximum changes it; c (N/m), y = yield_strain
//   plastic_set_coupled  the same on two strains, of which the first is remembered: sigma_1 as
//   above, and
//                sigma_2 = -d max(0, m - y), since a rest length that moves also moves what the
//                first strain does to the second; d = coupling (N/m)
//
//   softening    sigma = -k eps^n (1 - exp(-(m - eps)/e)): what the first loading had and no later
//   one has (Mullins,
//                settling); the loss grows with strain as its n-th power and ends within the strain
//                e of the old maximum; k (N/m), e = strain_scale, n = power (fixed in fits)
//
// One strain where nothing else is said; a pull is a positive strain. State: m.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class PlasticSetLaw final : public Law {
 public:
  PlasticSetLaw() : Law(1, 2, 1) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

class CoupledPlasticSetLaw final : public Law {
 public:
  CoupledPlasticSetLaw() : Law(2, 3, 1) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

class SofteningLaw final : public Law {
 public:
  SofteningLaw() : Law(1, 3, 1) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

}  // namespace tenter::mechanics
