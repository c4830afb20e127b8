// SPDX-License-Identifier: GPL-3.0-or-later
// Dahl's friction in the forms of the thesis, side by side: the stress after the strain went
// straight from e0, with stress s0 there, to e1. s is the sign of the way.
//
//   original (5.1)         d sigma/d eps = alpha sgn(w) |w|^gamma,  w = 1 - s sigma / sigma_max
//   constant tau (5.2)     d sigma/d eps = (sigma_max(eps) - s sigma) / tau
//   approximate (5.3)      s sigma_max(e1) + (s0 - s sigma_max(e0)) exp(-|e1 - e0| / tau)
//   constant slope         (5.1) with gamma = 1 and sigma_max(eps), figure 5.3 right
//
// with sigma_max = a + b |eps|. 5.3 leaves out the b tau of
//
//   sigma = s sigma_max(e1) - b' tau + (s0 - s sigma_max(e0) + b' tau) exp(-|e1 - e0| / tau)
//
// (b' = b times the sign of the strain), which is the exact solution of 5.2 and what the law "dahl"
// is (laws/dahl.h): their difference is b' tau (1 - exp(-|e1 - e0| / tau)), at most |b tau| on one
// side of zero. All but 5.3 do not see how a way is cut. Where a way crosses zero it is split
// there.
//
//   double exact = dahl_constant_tau(0.0, 0.0, 0.02, {a, b}, tau);
//   double papers = dahl_approximate(0.0, 0.0, 0.02, {a, b}, tau);
//
// Stresses N/m (bending: N), strains 1 (1/m). Closed forms; any thread.
#pragma once

namespace tenter::mechanics {

struct FrictionMaximum {
  double a = 0.0;  ///< > 0
  double b = 0.0;  ///< >= 0

  double at(double strain) const { return a + b * (strain < 0.0 ? -strain : strain); }
};

/// 5.1 with a constant sigma_max > 0 and gamma >= 0; |s0| <= sigma_max, where it also stays.
double dahl_original(double e0, double s0, double e1, double sigma_max, double alpha, double gamma);

double dahl_constant_tau(double e0, double s0, double e1, const FrictionMaximum& maximum,
                         double tau);
double dahl_approximate(double e0, double s0, double e1, const FrictionMaximum& maximum,
                        double tau);
double dahl_constant_slope(double e0, double s0, double e1, const FrictionMaximum& maximum,
                           double alpha);

}  // namespace tenter::mechanics
