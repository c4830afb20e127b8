// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/friction/dahl_work.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {
namespace {

double maximum_at(double strain, const double* p) {
  const double e = std::abs(strain);
  return p[0] + p[1] * e + p[2] * e * e;
}

}  // namespace

double stored_friction(double strain, double stress, const double* p) {
  return stress == 0.0 ? 0.0 : 0.5 * p[3] * stress * stress / maximum_at(strain, p);
}

FrictionWork friction_work(double e0, double s0, double e1, const double* p) {
  const DahlStep step = dahl_step(e0, s0, e1, p);
  FrictionWork work;
  work.done = step.potential;
  work.stored = stored_friction(e1, step.stress, p) - stored_friction(e0, s0, p);
  work.lost = work.done - work.stored;
  return work;
}

// f(e) = 2 sigma_max - tau sigma_max' = (2 a - tau b) + 2 (b - tau c) e + 2 c e^2 for e >= 0,
// convex: least at e = (tau c - b) / (2 c) where that is positive, else at rest.
DissipationCheck check_dissipation(const double* p, double largest) {
  const double a = p[0], b = p[1], c = p[2], tau = p[3];
  const auto f = [&](double e) {
    return 2.0 * a - tau * b + 2.0 * (b - tau * c) * e + 2.0 * c * e * e;
  };
  DissipationCheck check;
  if (c > 0.0) check.worst_strain = std::clamp((tau * c - b) / (2.0 * c), 0.0, largest);
  const double maximum = maximum_at(check.worst_strain, p);
  const double slope = tau * (b + 2.0 * c * check.worst_strain);
  check.worst = slope == 0.0 ? 0.0 : slope / (2.0 * maximum);
  check.holds = f(check.worst_strain) >= 0.0;
  if (check.holds) return check;
  // the roots of f beside the worst strain, within the range
  const double linear = b - tau * c, constant = 2.0 * a - tau * b;
  double low = 0.0, high = largest;
  if (c > 0.0) {
    const double root = std::sqrt(std::max(0.0, linear * linear - 2.0 * c * constant));
    low = (-linear - root) / (2.0 * c);
    high = (-linear + root) / (2.0 * c);
  } else if (linear > 0.0) {
    high = -constant / (2.0 * linear);
  }
  check.fails_from = std::clamp(low, 0.0, largest);
  check.fails_to = std::clamp(high, 0.0, largest);
  return check;
}

double largest_growth(double a, double tau) {
  return 2.0 * a / tau;
}

}  // namespace tenter::mechanics
