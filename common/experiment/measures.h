// SPDX-License-Identifier: Apache-2.0
// A number of a run, as the scene's experiment asks for it (common/scene/experiment.h).
//
//   mean_strain, rms_strain  of a strain at a moment, each element by the share it stands for
//   rms_curvature            of a bending, kappa = eps / 3 (thesis 5.3.3), 1/m
//   work                     done by whoever moves a clip, from one moment to another, J:
//                            sum of -(F_i + F_i+1)/2 . (x_i+1 - x_i) over the frames; of a path
//                            that closes, the loop's area
//   force_difference         max |F - F_1| / max |F_1| over all frames, F_1 of the first run
//   kinetic_energy           at a moment, J; of motions
//   curvature_change, wrinkle_height, wrinkle_likeness, settling_time: wrinkle_measures.h
//
//   Expected<Value> v = measured(measure, run, first_run);
//   if (v && v->number) print(*v->number, v->unit);
//
// bad_input: no term has the strain, the kind is for motions or for hinges only. No number where
// the run ended before the moment. Pure; any thread; linear in what is summed.
#pragma once

#include <optional>
#include <string>

#include "common/base/error.h"
#include "common/frames/frames.h"
#include "common/scene/experiment.h"

namespace tenter::experiment {

struct Value {
  std::optional<double> number;
  std::string unit;
};

Expected<Value> measured(const scene::Measure& measure, const frames::FrameSet& run,
                         const frames::FrameSet& first);

}  // namespace tenter::experiment
