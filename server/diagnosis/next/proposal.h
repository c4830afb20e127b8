// SPDX-License-Identifier: GPL-3.0-or-later
// A capture that would tell causes apart, in numbers. Values.
#pragma once

#include <cmath>
#include <string>

#include "server/diagnosis/next/experiment.h"

namespace tenter::diagnosis {

/// What the rig may do. Zero: taken from the captures.
struct RigLimits {
  double largest_strain = 0.0;  ///< zero: one and a half times the largest of the captures
  double largest_N_m = 0.0;     ///< zero: one and a half times the largest measured
  double fastest_per_s = 0.0;   ///< zero: the fastest of the captures; 0.01 where none is known
  double longest_s = 3600.0;
};

/// How far apart two models are expected to be (separation.h).
struct Separation {
  double chi2 = 0.0;  ///< S
  int rows = 0;       ///< readings of the experiment
  /// Largest force that either foretells (N/m).
  double largest_N_m = 0.0;

  /// rms over the readings, in sigmas
  double of_noise() const { return rows > 0 ? std::sqrt(chi2 / rows) : 0.0; }
};

struct Design {
  Experiment plan;
  std::string mounted_as;  ///< title of the capture
  Separation separation;   ///< of the pair that is closest
  int considered = 0;      ///< experiments within the limits
};

}  // namespace tenter::diagnosis
