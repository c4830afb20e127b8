// SPDX-License-Identifier: GPL-3.0-or-later
// How far a model is from one measured sequence, in the units of Tables A.1 to A.4 and 4.1:
//
//   force     root mean square over frames and clips of predicted - measured force, N; of shear
//             only the forces along the clips (thesis 3.4.1)
//   position  root mean square distance over frames and free points, mm
//
//   auto residual = scenario_residual(model, {Role::bend_u, sequence});
//   row << residual->position_mm;
//
// Nothing is fitted. Frames without a rest are counted and left out. Pure; one thread; costs a
// solve for equilibrium a frame.
#pragma once

#include <string>

#include "server/estimation/staged/roles.h"

namespace tenter::estimation {

struct ScenarioResidual {
  std::string sequence;
  Role role = Role::evaluation;
  double force_N = 0.0;
  double position_mm = 0.0;
  int force_rows = 0;  ///< 0: no force was measured
  int points = 0;      ///< measured, free, over all frames
  int frames = 0;      ///< with a rest
  int restless = 0;    ///< without
};

/// `tolerance_N`: net force of a frame at rest. Errors as resting_frames().
Expected<ScenarioResidual> scenario_residual(const model::Model& model,
                                             const RoleSequence& measured,
                                             double tolerance_N = 1e-6);

}  // namespace tenter::estimation
