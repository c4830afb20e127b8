// SPDX-License-Identifier: GPL-3.0-or-later
// What is done to the twin's swatches: the suites of planned captures, frame by frame, before any
// material is known.
//
//   rich         strip pulls along x and y with nested loops to 2, 4, 6, 8 % (each back to zero,
//   three repeats),
//                two rates a decade apart, a hold of 60 s; a pull with a free, observed transverse
//                direction; equibiaxial, shear and 45 degree loops. About 1,300 frames
//   single_rate  the same loops at one rate, no hold: friction and viscosity cannot be told apart
//   no_time      single_rate with neither time nor rate recorded
//   specimens    three specimens, pulled along x and all but the last along y: nested loops, two
//   repeats, and a hold at another rate
//   knit_like    loading-only pulls along x and along y, five repeats each, free transverse
//   direction observed;
//                the way back to zero happens but is not recorded
//
// Each capture is a fresh swatch of the same cloth; its runs continue each other's history.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "tests/twin/random.h"

namespace tenter::twin {

/// One instant of a plan. Strains are engineering strains of the test axes, as the machine reports
/// them.
struct PlannedFrame {
  double time_s = 0.0;
  double strain_x = 0.0;
  double strain_y = 0.0;
  double shear = 0.0;
  int run = 0;
  int phase = 0;
  capture::Branch branch = capture::Branch::other;
  bool recorded = true;  ///< false: it happens to the cloth, but no frame is written
};

/// A planned capture. A free axis has no load cell; its stretch is observed.
struct PlannedCapture {
  std::string name;
  int specimen = 0;        ///< of those that do the same protocols, from 1; 0: one swatch alone
  std::string protocol;    ///< "": as the name
  double angle_rad = 0.0;  ///< from weft to the test's x axis
  bool free_x = false;
  bool free_y = false;
  bool shears =
      false;  ///< the xy component is prescribed and its stress measured; otherwise fixed at zero
  bool has_time = true;
  std::vector<capture::Run> runs;
  std::vector<capture::Phase> phases;
  std::vector<PlannedFrame> frames;
};

const std::vector<std::string>& suite_names();
/// Whether several specimens do the same.
bool has_specimens(const std::string& suite);

/// Plans a suite. `choices` sets the jitter of the frames (each run is sampled at its own
/// instants). Fails where there is no suite of that name.
Expected<std::vector<PlannedCapture>> plan_suite(const std::string& suite, Random choices);

}  // namespace tenter::twin
