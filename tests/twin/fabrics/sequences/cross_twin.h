// SPDX-License-Identifier: GPL-3.0-or-later
// Twins from the smooth sheet (sheet/) as the estimator takes them: measured at irregular places of
// the material, to be compared with a grid by material coordinates.
//
//   const Fabric wool = fabric("18");
//   auto twin = cross_twin(wool, make_protocol(wool, "shear"), {});
//   add_rig_noise({}, random, twin->sequence);
//
// Every frame starts where the sheet is at the grid's nodes (the measured configuration of thesis
// 3.4.1, smoothed). Places under a clip are no channel; those on the table are not seen.
//
// Error: no rest in a frame. One thread.
#pragma once

#include <vector>

#include "tests/twin/fabrics/sequences/sequence_of.h"
#include "tests/twin/fabrics/sheet/sheet_twin.h"

namespace tenter::twin {

struct CrossOptions {
  GridOptions grid;  ///< its points_m are taken; none: `places` irregular ones
  int places = 2500;
  SheetTwinOptions sheet;
};

struct CrossTwin {
  estimation::Sequence sequence;
  int unknowns = 0;    ///< of the sheet
  int iterations = 0;  ///< over all frames
};

Expected<CrossTwin> cross_twin(const Fabric& fabric, const Protocol& protocol,
                               CrossOptions options = {});

/// One run of the sheet for several grids, `nodes` a side each: the same measured values.
Expected<std::vector<CrossTwin>> cross_twins(const Fabric& fabric, const Protocol& protocol,
                                             CrossOptions options, const std::vector<int>& nodes);

}  // namespace tenter::twin
