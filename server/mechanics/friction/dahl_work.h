// SPDX-License-Identifier: GPL-3.0-or-later
// Where the work of friction goes: a part is stored and given back, the rest is lost.
//
//   V = tau sigma^2 / (2 sigma_max)                               stored, J/m^2 (bending: J/m^2)
//   D = sigma^2 |d eps| / sigma_max  (1 + s tau sigma_max' / (2 sigma_max))     lost
//   sigma d eps = dV + D
//
// D >= 0 on every way exactly where tau |sigma_max'| <= 2 sigma_max, for sigma_max = a + b |eps|
// that is b tau <= 2 (a + b |eps|); sigma_max = a + b |eps| + c eps^2, so sigma_max' = b + 2 c
// |eps|. Nearest to failing at rest, unless c makes it fail farther out. Where it fails a step may
// gain work; a steady cycle that stays out of there never does.
//
//   const FrictionWork work = friction_work(e0, s0, e1, parameters);
//   if (!check_dissipation(parameters, largest_strain).holds) ...
//
// Parameters a, b, c, tau as of laws/dahl.h. Closed forms; any thread.
#pragma once

#include "server/mechanics/laws/dahl.h"

namespace tenter::mechanics {

/// V at a stress and strain.
double stored_friction(double strain, double stress, const double* parameters);

struct FrictionWork {
  double done = 0.0;    ///< integral of the stress over the step
  double stored = 0.0;  ///< change of V
  double lost = 0.0;    ///< what is left: never negative where the dissipation holds
};
FrictionWork friction_work(double e0, double s0, double e1, const double* parameters);

struct DissipationCheck {
  bool holds = true;
  double worst_strain = 0.0;  ///< magnitude where 2 sigma_max - tau sigma_max' is least
  double worst = 0.0;         ///< tau sigma_max' / (2 sigma_max) there: fails above 1
  /// Magnitudes of strain between which it fails; zero and zero where it holds.
  double fails_from = 0.0, fails_to = 0.0;
};
/// On strains of magnitude up to `largest`. Parameters: a, b, c >= 0, tau > 0.
DissipationCheck check_dissipation(const double* parameters, double largest);

/// The largest b with which it holds at every strain, for c = 0 or c tau <= b: 2 a / tau.
double largest_growth(double a, double tau);

}  // namespace tenter::mechanics
