// SPDX-License-Identifier: GPL-3.0-or-later
// A square of cloth of 7 x 7 nodes in the five sequences of thesis 3.2.2, measured at every node
// with or without noise: what staged fits are tried on.
#pragma once

#include <random>

#include "server/estimation/staged/roles.h"

namespace tenter::estimation {

struct RigOptions {
  int nodes = 7;
  int frames = 5;
  double point_sigma_m = 2e-5;
  double force_sigma_N = 2e-3;
  double noise = 1.0;  ///< in standard deviations
  unsigned seed = 1;
};

/// The truth is the model's own parameters. Fails the test where a frame has no rest.
RoleSequence measured_in_rig(Role role, const model::Model& truth, const RigOptions& options);
std::vector<RoleSequence> measured_in_rig(const model::Model& truth, const RigOptions& options);

/// cloth_stvk with three stiffness curves that are not constant (B-splines of five points over
/// given ranges) and plain bending.
model::Model curved_cloth();

}  // namespace tenter::estimation
