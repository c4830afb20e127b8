// SPDX-License-Identifier: GPL-3.0-or-later
// A start for all five parameters of bending at once, from measured curvatures and torques.
//
//   T_i = (k1 + k2 eps_i) eps_i + a A_i(tau) + b B_i(tau)
//
// Dahl's stress along a given way is linear in a and b (A, B: the law with a or b one, from flat to
// the cylinder and back to eps_i); so for each tau the rest is a linear least-squares problem with
// bounds. Cantilevers go from flat to eps_i, and so the stiffness is free of their friction.
//
// Pure; any thread. Cost: 40 small linear problems, 10 ms.
#pragma once

#include <vector>

#include "server/estimation/friction_tests/bending/torque_samples.h"
#include "server/estimation/friction_tests/friction_model.h"

namespace tenter::estimation {

/// The best few of a row of values of tau, best first; empty where there are no samples.
std::vector<FrictionValues> path_starts(const std::vector<ProfileSamples>& profiles);

}  // namespace tenter::estimation
