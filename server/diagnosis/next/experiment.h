// SPDX-License-Identifier: GPL-3.0-or-later
// A pull that the rig could do next: one component of strain, or clips along a way that they went
// before, ramp after ramp, with holds; all else mounted as in a capture that is there.
//
//   Experiment plan{"two rates", 0, {ramp_to(0.06, 1e-3), ramp_to(0.0, 1e-3)}};
//   Curves curves = curves_of(plan, data.curves[0], data.sigma[0]);   // nothing measured yet:
//   zeros
//
// Values.
#pragma once

#include <string>
#include <vector>

#include "server/estimation/prediction.h"

namespace tenter::diagnosis {

/// In the place of a component, of sheets: strain is how far clips move about their middle, over
/// their farthest distance from it.
constexpr int kWayOfClips = 3;

struct ExperimentStep {
  bool is_hold = false;
  double strain = 0.0;      ///< engineering strain (of shear its angle's tangent) at the end
  double rate_per_s = 0.0;  ///< of a ramp
  double seconds = 0.0;     ///< of a hold
};

ExperimentStep ramp_to(double strain, double rate_per_s);
ExperimentStep hold_for(double seconds);  ///< where the step before ended

struct Experiment {
  std::string name;   ///< "two_rates_and_hold"
  int component = 0;  ///< 0: x, 1: y, 2: xy of the capture whose mounting is taken; kWayOfClips
  std::vector<ExperimentStep> steps;

  double duration_s() const;
  double largest_strain() const;  ///< of its magnitudes
  /// A hold, or rates a factor of three apart: what tells friction from viscosity.
  bool splits_rate() const;
};

/// A virgin specimen in the mounting of `like`, through the steps: `kFrames` a ramp, the other
/// components as `like` starts. Every channel of `like` is there and reads zero.
estimation::Curves curves_of(const Experiment& plan, const estimation::Curves& like);

/// "x", "y", "xy" or "clips".
const char* name_of_component(const Experiment& plan);

/// One sentence with numbers: "Cycle x to 6 % at 0.1 %/s ..." for each step or pair of steps.
std::vector<std::string> words_of(const Experiment& plan);

}  // namespace tenter::diagnosis
