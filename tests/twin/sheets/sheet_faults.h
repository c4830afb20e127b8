// SPDX-License-Identifier: GPL-3.0-or-later
// What the rig and its instruments do wrong, and what they read of a sheet.
//
// Before the sheet moves: a clip that slips, one with play, a mass that is not the one stated. A
// force then passes its cord, the clocks and its cell: friction against the motion, shown late, a
// gain, an offset, a drift with the clock, and no more than a cap. Points: drawn towards the camera
// beside what is hidden, turned and shifted, scaled; some of them misread. Shares nothing with
// server/.
//
//   auto done = perform(suite, fabric, faults);            // equilibria: what costs
//   SheetReadings readings = read(suite, *done, faults);
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "tests/twin/fabrics/sheet/sheet_twin.h"
#include "tests/twin/sheets/sheet_suite.h"

namespace tenter::twin {

struct SheetFaults {
  // of the sheet and what holds it
  int slip_plan = -1, slip_frame = 0;  ///< a frame of the path
  double slip_m = 0.0;                 ///< of the moved bar, back
  double play_m = 0.0;                 ///< of the moved bars' grips, foreign
  double mass_factor = 1.0;            ///< true over stated
  // of load cells
  std::string cell;  ///< whose these are
  double offset_N = 0.0, gain = 1.0, drift_N_s = 0.0, cord_friction = 0.0;
  double cap_N = 1e300;
  double delay_s = 0.0;                     ///< of all
  double alias_s = 0.0, alias_turns = 0.0;  ///< clock that beats with the frames, foreign
  // of cameras
  double scale = 1.0;
  int posed_plan = -1;
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero(), shift_m = Eigen::Vector3d::Zero();
  double occlusion_m = 0.0;
  /// A point that is taken for another one for a frame.
  struct Misread {
    int plan = 0, seen = 0, place = 0;
    Eigen::Vector3d jump_m = Eigen::Vector3d::Zero();
  };
  std::vector<Misread> misread;

  /// The sheet itself moves as it would without.
  bool spares_the_sheet() const { return slip_plan < 0 && play_m == 0.0 && mass_factor == 1.0; }
};

/// All frames of each path.
struct SheetDone {
  std::vector<SheetTwin> plans;
};

struct SheetReadings {
  struct Frame {
    Eigen::Matrix3Xd points_m;  ///< one column a place of the suite
    Eigen::VectorXd forces_N;   ///< one a cell of the plan
  };
  std::vector<std::vector<Frame>> plans;  ///< frames that are seen
};

/// Places that a frame does not see: NaN in readings.
using Hidden3 = std::vector<std::vector<std::vector<bool>>>;  ///< [plan][seen frame][place]
Hidden3 hidden_places(const SheetSuite& suite, Random choices);

/// Also where the nodes of `grid_nodes` a side lie, after the suite's places. `plans` at most: the
/// first so many.
Expected<SheetDone> perform(const SheetSuite& suite, const Fabric& fabric,
                            const SheetFaults& faults, std::size_t plans = 100);

/// Points that are hidden stay in.
SheetReadings read(const SheetSuite& suite, const SheetDone& done, const Hidden3& hidden,
                   const SheetFaults& faults);

/// Material places of the suite, then of the grid's nodes.
std::vector<Eigen::Vector2d> all_places(const SheetSuite& suite, double side_m);

}  // namespace tenter::twin
