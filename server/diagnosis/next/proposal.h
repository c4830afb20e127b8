// SPDX-License-Identifier: GPL-3.0-or-later
// A capture that would tell causes apart, in numbers. Values.
#pragma once

#include <cmath>
#include <string>

#include "server/diagnosis/next/experiment.h"

namespace tenter::diagnosis {

/// Of what was captured, where nobody says what the rig may do.
constexpr double kWiderThanCaptured = 1.5;

/// What the rig may do. Zero: taken from the captures.
struct RigLimits {
  double largest_strain = 0.0;  ///< zero: one and a half times the largest of the captures
  double largest_N_m = 0.0;     ///< of curves; zero: one and a half times the largest measured
  double largest_N = 0.0;       ///< of a clip of a sheet; zero: as above
  double fastest_per_s = 0.0;   ///< zero: the fastest of the captures; 0.01 where none is known
  double longest_s = 3600.0;
};

/// How far apart two models are expected to be (separation.h).
struct Separation {
  double chi2 = 0.0;     ///< S
  int rows = 0;          ///< readings of the experiment
  int telling_rows = 0;  ///< of these, of the kind that shows most of it
  /// Largest that either foretells: N/m of curves, N at a clip of sheets.
  double largest_force = 0.0;

  /// rms over the readings that tell, in sigmas
  double of_noise() const { return telling_rows > 0 ? std::sqrt(chi2 / telling_rows) : 0.0; }
};

struct Design {
  Experiment plan;
  std::string mounted_as;  ///< title of the capture
  Separation separation;   ///< of the cause in the model from the one that is closest
  int considered = 0;      ///< experiments within the limits
};

}  // namespace tenter::diagnosis
