// SPDX-License-Identifier: GPL-3.0-or-later
// Friction by what it does to a linear elastic material without load (thesis 5.2.3): the strain
// that stays, and the strain that has to be reached before no more than that stays.
//
//   eps_per   persistent deformation of a material of stiffness k after saturated unloading:
//             k eps_per = a + b eps_per + b tau           (thesis: sigma_max = k eps_per, b = 0)
//   eps_sat   unloading from there to eps_per saturates to the part c of sigma_max:
//             tau = (eps_sat - eps_per) / ln(2 / (1 - c))              (alpha = sigma_max / tau)
//
// The b tau is that of the exact solution of 5.2: saturated unloading ends at -(sigma_max + b tau).
//
//   auto tuned = tune_friction({.stiffness = 135.6, .persistent = 0.016, .saturation = 0.04});
//   tuned->a, tuned->b, tuned->tau
//
// Stiffness N/m (bending: N m), strains 1 (1/m). Any thread.
#pragma once

#include "common/base/error.h"

namespace tenter::mechanics {

struct FrictionWish {
  double stiffness = 0.0;   ///< k > 0
  double persistent = 0.0;  ///< eps_per > 0
  double saturation = 0.0;  ///< eps_sat > eps_per
  double growth = 0.0;      ///< b >= 0 of sigma_max = a + b |eps|, below k
  double saturated = 0.95;  ///< c, between 0 and 1
};

struct TunedFriction {
  double a = 0.0, b = 0.0, tau = 0.0;
};

/// bad_input names the number and its bound: also where so large a growth leaves a <= 0, or breaks
/// b tau <= 2 a (friction that gains work near rest).
Expected<TunedFriction> tune_friction(const FrictionWish& wish);

/// The strain at which saturated unloading of a linear material ends; zero where b reaches k.
double persistent_strain(double stiffness, const TunedFriction& friction);

}  // namespace tenter::mechanics
