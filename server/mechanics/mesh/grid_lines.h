// SPDX-License-Identifier: GPL-3.0-or-later
// Where the lines of a grid lie that is not the same everywhere: through given places, and the
// denser the nearer to others, such as the ends of clips.
//
//   density ~ r^(1/beta - 1)        r: distance to the nearest of the places, beta >= 1
//
// so that beside one place, L from the next, line k of n lies at L (k / n)^beta (a graded mesh: G.
// Raugel, C. R. Acad. Sci. Paris 286, 1978). At a corner of 270 degrees of cloth about a clip
// displacements grow by r^0.54 to r^0.67 and their gradients have no bound; linear triangles on
// equal cells then lose half of the order, which beta above 1 / 0.54 gives back.
//
//   // 24 cells, a clip from 0 to 10 mm whose end the lines are dense at
//   auto lines = graded_lines({.hi_m = 0.1, .cells = 24, .through_m = {0.01},
//                              .towards_m = {0.01}, .beta = 3.0});
//
// Cells go to the stretches between given places by the integral of the density, at least one to
// each, alike to what is alike.
//
// Pure; cost is cells times places.
#pragma once

#include <vector>

#include "common/base/error.h"

namespace tenter::mechanics {

struct LineGrading {
  double lo_m = 0.0;
  double hi_m = 0.0;
  int cells = 1;
  std::vector<double> through_m = {};  ///< strictly between lo and hi, in any order
  std::vector<double> towards_m = {};  ///< of [lo, hi]; none: equal cells between given places
  /// Stretches between neighbouring places of `through_m` that get one cell each: what is rigid.
  std::vector<double> one_cell_at_m = {};  ///< a place inside of each
  double beta = 1.0;                       ///< 1: equal cells
};

/// cells + 1 rising places from lo to hi. bad_input for places outside, beta below 1, two given
/// places closer than a millionth of the length, or fewer cells than stretches.
Expected<std::vector<double>> graded_lines(const LineGrading& grading);

}  // namespace tenter::mechanics
