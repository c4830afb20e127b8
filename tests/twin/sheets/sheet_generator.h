// SPDX-License-Identifier: GPL-3.0-or-later
// Sheets of the examination: a cloth in the rig, seen through noise, in which effects of a known
// size hide. What generator.h is to curves; nothing of server/ is used.
//
//   auto twin = make_sheets({.effects = {"heterogeneity"}, .size = 3.0, .suite = "sheet_field"});
//   twin->readings.plans[p][f].forces_N[k]         NaN where a point was not seen
//
// The cloth is drawn anywhere from compliant to stiff, what the instruments state of their noise is
// wrong by up to a factor of two either way. Cost: some ten runs of the suite, a second or two
// each.
#pragma once

#include "tests/twin/generator.h"
#include "tests/twin/sheets/sheet_ruler.h"

namespace tenter::twin {

struct SheetTwins {
  SheetSuite suite;
  Fabric stated;  ///< what is known of the cloth: its size and mass
  SheetBaseline baseline = SheetBaseline::diagonal;
  SheetReadings readings;  ///< with noise; NaN where a place is not seen
  SheetDone done;          ///< where the sheet truly was, nodes of the grid included
  SheetNoise noise, stated_noise;
  double guess_k_N_m = 0.0;  ///< a stretch stiffness within a factor of two
  std::vector<Hidden> hidden;
};

/// bad_input: an unknown effect or suite, effects that a suite cannot show or that need different
/// baselines, a sheet without rest. `more`: done after the suite's, with effects as large as the
/// suite alone asks for.
Expected<SheetTwins> make_sheets(const TwinCase& twin_case,
                                 const std::vector<SheetPlan>& more = {});

}  // namespace tenter::twin
