// SPDX-License-Identifier: GPL-3.0-or-later
// Energy as a sum of Gaussians (thesis 4.2), for terms of one strain or of two:
//
//   Psi(eps) = sum_j phi(|eps - eps_j|) w_j,   phi(r) = exp(-r^2 / (2 h^2))
//
// The centres eps_j are even over [range_lo, range_hi], on a square grid for two strains (the first
// strain's centre changes fastest), and h is the distance of neighbours. The energy counts from
// rest (Psi(0) is taken off); at rest it may have a stress, and far outside the range it has none.
// Linear in its parameters; not convex by itself (convexity.h).
#pragma once

#include "server/mechanics/law.h"

namespace tenter::mechanics {

class GaussianEnergyLaw final : public Law {
 public:
  /// `side` >= 2 centres along each of one or two strains, range_lo < range_hi.
  GaussianEnergyLaw(int strains, int side, double range_lo, double range_hi);
  void evaluate(const LawInput& in, LawOutput& out) const override;

 private:
  /// exp(-x^2/(2 h^2)) at each centre, with its derivatives by the strain.
  struct Factor {
    double value[kMaxLawParameters];
    double first[kMaxLawParameters];
    double second[kMaxLawParameters];
  };
  void factor(double strain, Factor& out) const;

  int side_;
  double lo_;
  double spacing_;
  std::vector<double> at_rest_;  ///< each Gaussian at strain 0
};

}  // namespace tenter::mechanics
