// SPDX-License-Identifier: GPL-3.0-or-later
// Damping after Baraff and Witkin (1998): every strain with a stiffness resists its own rate,
//
//   sigma_d = eta d eps/dt      eta = time_s k(unit strain)
//
// as a term of the model with the law kelvin_voigt. The friction paper (section 6) takes a tenth to
// a hundredth of the stiffness at unit strain: time_s = 0.1 to 0.01. Rigid motions are not damped.
//
//   auto damped = with_damping(model, 0.01);
//
// Pure.
#pragma once

#include "common/base/error.h"
#include "common/model/model.h"

namespace tenter::mechanics {

/// Adds a term ID_damping after the model's own for each of one strain whose law keeps no memory
/// and is stiff there (couplings of two strains have none). bad_input: a time that is negative or
/// no number, or what make_law says.
Expected<model::Model> with_damping(model::Model model, double time_s);

}  // namespace tenter::mechanics
