// SPDX-License-Identifier: GPL-3.0-or-later
// Laws that remember the largest strain m that the material has seen (m grows on first loadings only).
//
//   plastic_set  sigma = -c max(0, m - y): the rest length moves with each new maximum beyond the yield strain y, and
//                nothing but a new maximum changes it; c (N/m), y = yield_strain
//   softening    sigma = k eps exp(-m/e): a bundle of links that break for good as the strain first passes them, so
//                that only a first loading feels them whole (Mullins); k (N/m), e = strain_scale
//
// One strain. State: m.
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class PlasticSetLaw final : public Law {
 public:
  PlasticSetLaw() : Law(1, 2, 1) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

class SofteningLaw final : public Law {
 public:
  SofteningLaw() : Law(1, 2, 1) {}
  void evaluate(const LawInput& in, LawOutput& out) const override;
};

}  // namespace tenter::mechanics
