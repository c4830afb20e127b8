// SPDX-License-Identifier: GPL-3.0-or-later
// What the examination does with a sheet: captures between two bars and in a frame of four clips,
// where it looks at the sheet, and what it is told of time.
//
//   sheet_field    pulls along u and v (a loop, a larger one ten times slower with a hold), and a
//                  frame that stretches both ways and shears; another way of it is held out. Points
//                  all over, lost here and there, behind an obstacle in some frames
//   sheet_markers  the same, seen at a dozen tracked points
//   sheet_single_rate, sheet_no_time
//                  pulls at one rate without a hold; of the latter no time is told
//
// Frames lie unevenly between turns, and turns are no frames. Shares nothing with server/.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "tests/twin/fabrics/protocols.h"
#include "tests/twin/random.h"

namespace tenter::twin {

/// What a suite has to show, by its name.
struct SheetTraits {
  bool has_clock = true;     ///< time is told
  bool has_rates = true;     ///< two rates and holds: what tells friction from viscosity
  bool has_shear = true;     ///< stretch and shear come together
  bool has_obstacle = true;  ///< hides patches of the sheet
};

struct SheetPlan {
  std::string name;
  bool is_frame = false;  ///< four clips, forces along them are read, too; else two bars
  bool along_u = true;    ///< which way bars are pulled apart
  bool held_out = false;
  bool keeps_time = false;         ///< time is told of it, whatever the suite does
  Protocol path;                   ///< all that is done, turns too, with durations
  std::vector<int> seen;           ///< frames of the path that are frames of the capture, rising
  std::vector<std::string> cells;  ///< load cells of the rig, in the order of readings
};

struct SheetSuite {
  std::string name;
  double span_m = 0.0;  ///< longest between knots of the spline sheet that does it all
  int grid_cells = 8;   ///< of the grid that is fitted; clips end on its lines
  SheetTraits traits;
  std::vector<Eigen::Vector2d> places_m;  ///< that are tracked
  double spacing_m = 0.0;                 ///< between neighbours
  std::vector<SheetPlan> plans;
};

const std::vector<std::string>& sheet_suite_names();
bool is_sheet_suite(const std::string& name);

SheetTraits traits_of(const std::string& sheet_suite);

/// bad_input for a name that is none. `fabric` says how far its limits let it be pulled.
Expected<SheetSuite> plan_sheets(const std::string& name, const Fabric& fabric, Random choices);

}  // namespace tenter::twin
