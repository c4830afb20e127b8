// SPDX-License-Identifier: Apache-2.0
// What friction does to wrinkles (thesis Fig. 5.13 to 5.16), of the frames of a run:
//
//   curvature_change   sqrt(sum S (kappa - kappa')^2 / sum S) from one moment to another, 1/m: over
//                      every bending strain of the model once, kappa = eps / 3, S what the hinge
//                      stands for (thesis 5.3.3)
//   wrinkle_height     height_m() of wrinkles.h, with the moment `from` as the smooth state, m
//   wrinkle_likeness   likeness() of the wrinkles at two moments, `from` again without wrinkles; no
//                      number where one of them has none (below kNoWrinkle_m)
//   settling_time      from a moment until the rms speed, sqrt(sum A |v|^2 / sum A) with the areas
//                      of the nodes at the start, stays below the bound (settling.h), s; no number
//                      where it does not until the last frame
//
// `from` left out is the start. bad_input: a model without bending, a mesh without triangles or
// with a degenerate smooth state, equilibria asked for their speed. No number where the run ended
// before a moment. Pure; any thread; wrinkles cost O(nodes^2).
#pragma once

#include "common/experiment/measures.h"

namespace tenter::experiment {

/// Heights (rms) below this are a smooth sheet and rounding.
inline constexpr double kNoWrinkle_m = 1e-6;

Expected<Value> curvature_change(const scene::Measure& measure, const frames::FrameSet& run);
Expected<Value> wrinkle_height(const scene::Measure& measure, const frames::FrameSet& run);
Expected<Value> wrinkle_likeness(const scene::Measure& measure, const frames::FrameSet& run);
Expected<Value> settling_time(const scene::Measure& measure, const frames::FrameSet& run);

}  // namespace tenter::experiment
