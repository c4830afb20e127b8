// SPDX-License-Identifier: GPL-3.0-or-later
// Figures 5.8 and 5.9 of the thesis from one set of strips and its fit, as SVG files.
//
//   NAME_profiles.svg    the contours            NAME_curvatures.svg   curvature along them (5.8)
//   NAME_torques.svg     torque against strain: read, and of the model    NAME_residuals.svg (5.9)
#pragma once

#include <string>

#include "server/estimation/friction_tests/bending/bending_fit.h"

namespace tenter::bench {

/// False where a file cannot be written. `folder` exists.
bool write_bending_figures(const std::string& folder, const std::string& name,
                           const estimation::BendingTests& tests,
                           const estimation::BendingEstimate& found);

}  // namespace tenter::bench
