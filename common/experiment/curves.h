// SPDX-License-Identifier: Apache-2.0
// A line of a run, as the scene's experiment asks for it (common/scene/experiment.h).
//
//   force_travel     force that holds a clip (N) against its travel since frame 0 (m), both along a
//                    direction; one point a frame
//   curvature_along  kappa = eps / 3 of a bending (1/m) along a direction of the material (m): mean
//                    over the hinges at the same place, each by the share it stands for
//   kinetic_energy   J against time (s); of motions
//
//   Expected<Line> line = line_of(curve, run);
//
// bad_input as measures.h. Empty where the run ended before the moment. Pure; any thread; linear in
// the frames, sorting the hinges.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/frames/frames.h"
#include "common/scene/experiment.h"

namespace tenter::experiment {

struct Line {
  std::string x_name, x_unit, y_name, y_unit;
  std::vector<double> x, y;
};

Expected<Line> line_of(const scene::Curve& curve, const frames::FrameSet& run);

}  // namespace tenter::experiment
