// SPDX-License-Identifier: GPL-3.0-or-later
// Figures and residuals of a test of bending.
//
//   strip_profile   the strips as they were seen                                 (fig. 5.8, left)
//   curvature       along them; the model's at the samples                       (fig. 5.8, right)
//   unloading       torque against strain, read and on the way back from three
//                   cylinders                                                    (fig. 5.9, top)
//   residual_torque torque of the weight - torque of the model at the strain that was read, with
//   the
//                   torque itself to compare                                     (fig. 5.9, below)
//   residual_strain strain that was read - strain of the model
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <utility>
#include <vector>

#include "common/report/residual_file.h"
#include "server/jobs/friction_test/strips/strip_part.h"

namespace tenter::jobs {

using NamedCaptures = std::vector<std::pair<std::string, capture::Capture>>;

/// Figures of the part, all of the first capture that has strips of it.
nlohmann::json strip_figures(const StripPart& part, const StripsOfCaptures& strips,
                             const NamedCaptures& captures);

/// One a capture that has strips of the part.
std::vector<report::ResidualTable> strip_residuals(const StripPart& part,
                                                   const StripsOfCaptures& strips,
                                                   const NamedCaptures& captures);

}  // namespace tenter::jobs
