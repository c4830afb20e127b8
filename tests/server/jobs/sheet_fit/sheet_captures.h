// SPDX-License-Identifier: GPL-3.0-or-later
// Small captures of a sheet for tests of jobs: a square of a known cloth, pulled, sheared or pushed
// over a table's edge, simulated on the grid that the fit uses, with seeded noise.
#pragma once

#include <string>

#include "common/capture/capture.h"
#include "common/model/model.h"

namespace tenter::testing {

/// "cloth_stvk" with the values that the captures are made with.
model::Model true_cloth();

struct SheetCaptureOptions {
  /// Or stretch_v, shear, bend_u, bend_v; "hung_v": the bar is free, and cords whose tensions grow
  /// to pull_N pull it along the warp, nearly through its middle.
  std::string role = "stretch_u";
  int nodes = 7;  ///< on a side
  int frames = 5;
  double reach = 1.0;  ///< of the usual pull
  double pull_N = 0.4;
  double sigma_m = 2e-5;
  double sigma_N = 3e-3;
  unsigned seed = 1;
  model::Model cloth = true_cloth();
};

/// Throws where it finds no equilibrium.
capture::Capture sheet_capture(const SheetCaptureOptions& options);

}  // namespace tenter::testing
