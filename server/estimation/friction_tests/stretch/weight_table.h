// SPDX-License-Identifier: GPL-3.0-or-later
// Readings of a hanging cloth: a weight, and how long the cloth is under it, in the order in which
// they were taken (thesis 5.3.2).
//
//   eps = ((L/L0)^2 - 1) / 2,   load = (weight + dead weight) / width,   w = L / L0
//
// Branches and anchors are found from the order of the weights alone: a reading is on a loading
// branch where the weight grew, on an unloading one where it fell (the same weight once more: as
// before); the anchor is the reading at which the branch began, which is the last one at 0 N or at
// the largest weight for the papers' cycles, and any turning point for partial ones. The first
// reading of a run has no anchor.
//
//   Expected<WeightTable> checked = check(table);
//   std::vector<ReadingPlace> places = places_of(*checked);
//
// SI units; pure; any thread.
#pragma once

#include <vector>

#include "common/base/error.h"
#include "server/estimation/friction_tests/anchored_errors.h"

namespace tenter::estimation {

struct WeightReading {
  double weight_N = 0.0;
  double length_m = 0.0;
  int run = 0;  ///< readings of one run follow each other
};

enum class BetweenRuns {
  goes_on,   ///< the cloth was left hanging: friction stays as it was
  flattened  ///< friction was undone before each run
};

struct WeightTable {
  std::vector<WeightReading> readings;
  double rest_length_m = 0.1;
  double width_m = 0.1;
  double dead_weight_N = 0.0;   ///< clip, and what of the cloth hangs below its middle
  double length_noise_m = 0.0;  ///< of one reading; 0: taken from the fit's own residuals
  BetweenRuns between = BetweenRuns::goes_on;

  double load(std::size_t i) const;
  double strain(std::size_t i) const;
};

struct ReadingPlace {
  int anchor = -1;    ///< reading, -1: none
  double sign = 0.0;  ///< +1 loading, -1 unloading, 0 where there is no anchor
  int branch = 0;     ///< counted over the whole table
};

/// bad_input that names the reading: lengths and sizes above zero, finite numbers, at least eight
/// readings, weights that are not all the same.
Expected<WeightTable> check(WeightTable table);

std::vector<ReadingPlace> places_of(const WeightTable& table);

/// The papers' errors of all readings that have an anchor.
std::vector<AnchoredReading> anchored_readings(const WeightTable& table);

}  // namespace tenter::estimation
