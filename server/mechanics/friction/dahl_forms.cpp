// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/friction/dahl_forms.h"

#include <algorithm>
#include <cmath>

#include "server/mechanics/laws/dahl.h"

namespace tenter::mechanics {
namespace {

/// step(e0, s0, e1, side) on each side of zero in turn; side is +1 or -1.
template <class Step>
double split_at_zero(double e0, double s0, double e1, const Step& step) {
  const bool crosses = (e0 < 0.0 && e1 > 0.0) || (e0 > 0.0 && e1 < 0.0);
  if (!crosses) return step(e0, s0, e1, e0 + e1 >= 0.0 ? 1.0 : -1.0);
  return step(0.0, step(e0, s0, 0.0, e0 > 0.0 ? 1.0 : -1.0), e1, e1 > 0.0 ? 1.0 : -1.0);
}

}  // namespace

// With w = 1 - s sigma / sigma_max >= 0 and the way u = |e1 - e0|:
//   dw/du = -(alpha / sigma_max) w^gamma
//   w^(1 - gamma) = w0^(1 - gamma) + (gamma - 1) alpha u / sigma_max     (gamma = 1: exponential)
// For gamma < 1 the maximum is reached on a finite way, and kept.
double dahl_original(double e0, double s0, double e1, double sigma_max, double alpha,
                     double gamma) {
  const double s = e1 >= e0 ? 1.0 : -1.0;
  const double way = alpha * std::abs(e1 - e0) / sigma_max;
  const double w0 = std::max(0.0, 1.0 - s * s0 / sigma_max);
  if (w0 == 0.0 || way == 0.0) return s0;
  constexpr double kOne = 1e-9;  // the difference from the exponential is rounding
  double w = w0 * std::exp(-way);
  if (std::abs(gamma - 1.0) > kOne) {
    const double power = std::pow(w0, 1.0 - gamma) + (gamma - 1.0) * way;
    w = power > 0.0 ? std::pow(power, 1.0 / (1.0 - gamma)) : 0.0;
  }
  return s * sigma_max * (1.0 - w);
}

double dahl_constant_tau(double e0, double s0, double e1, const FrictionMaximum& maximum,
                         double tau) {
  const double parameters[] = {maximum.a, maximum.b, 0.0, tau};
  return dahl_step(e0, s0, e1, parameters).stress;
}

double dahl_approximate(double e0, double s0, double e1, const FrictionMaximum& maximum,
                        double tau) {
  const double s = e1 >= e0 ? 1.0 : -1.0;
  return split_at_zero(e0, s0, e1, [&](double from, double stress, double to, double) {
    return s * maximum.at(to) + (stress - s * maximum.at(from)) * std::exp(-s * (to - from) / tau);
  });
}

// sigma' + (s alpha / m) sigma = alpha with m = a + b' eps has the integrating factor m^n,
// n = s alpha / b':
//   sigma = alpha m / (s alpha + b') + C m^-n
// and for s alpha + b' = 0 (a way back at which m falls as fast as the stress may change)
//   sigma = m (s0 / m0 + (alpha / b') log(m / m0)).
double dahl_constant_slope(double e0, double s0, double e1, const FrictionMaximum& maximum,
                           double alpha) {
  if (maximum.b == 0.0) return dahl_original(e0, s0, e1, maximum.a, alpha, 1.0);
  const double s = e1 >= e0 ? 1.0 : -1.0;
  return split_at_zero(e0, s0, e1, [&](double from, double stress, double to, double side) {
    const double b = side * maximum.b;
    const double m0 = maximum.at(from), m1 = maximum.at(to);
    const double growth = std::log(m1 / m0);
    const double sum = s * alpha + b;
    constexpr double kNone = 1e-9;
    if (std::abs(sum) < kNone * alpha) return m1 * (stress / m0 + alpha / b * growth);
    const double slope = alpha / sum;
    return slope * m1 + (stress - slope * m0) * std::exp(-s * alpha / b * growth);
  });
}

}  // namespace tenter::mechanics
