// SPDX-License-Identifier: GPL-3.0-or-later
// The machine that pulls the twin's swatches: plan + cloth + faults -> what noise-free instruments
// would read.
//
// Faults of the grips change what the cloth feels; faults of the instruments change what is read.
// Every capture starts with a tared load cell and a virgin swatch; wall-clock time runs on over its
// runs and the rests between them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "tests/twin/cloth.h"
#include "tests/twin/suite.h"

namespace tenter::twin {

/// Pairs are {x, y} of the test axes.
struct Faults {
  // load cells
  std::array<double, 2> offset_N_m = {0.0, 0.0};
  std::array<double, 2> gain = {1.0, 1.0};
  std::array<double, 2> drift_N_m_s = {0.0, 0.0};
  std::array<double, 2> cap_N_m = {1e300, 1e300};  ///< flat top: the cell shows nothing above
  std::array<double, 2> step_N_m = {0.0, 0.0};     ///< of the display, see show_in_steps; 0: none
  // cords
  std::array<double, 2> cord_friction = {0.0, 0.0};  ///< mu: T (1 + mu) pulled, T (1 - mu) let back
  // cameras: an observed stretch is shown as rest + scale (stretch - rest)
  double camera_scale = 1.0;
  double camera_rest = 1.0;  ///< 1: changes of length over a known rest length; 0: lengths
  // clocks
  double force_delay_s = 0.0;  ///< force read at time t is the force of t - delay; all cells
  double clock_alias_s = 0.0;  ///< amplitude of a beat between the clocks of force and strain
  double clock_alias_frames = 0.137;  ///< beats per frame
  // isolated misreadings of the load cells
  double outlier_N_m = 0.0;
  double outlier_share = 0.01;
  std::uint64_t outlier_seed = 0;
  // grips
  double slip_strain = 0.0;  ///< lost once at frame `slip_frame` of capture 0, until that run ends
  int slip_run = 0;
  std::size_t slip_frame = 0;
  double backlash_strain = 0.0;  ///< free travel at each reversal
  // the swatch's surroundings
  double expansion_strain = 0.0;  ///< amplitude of a periodic free expansion, both axes
  double expansion_period_s = 200.0;
  double expansion_phase_rad = 0.0;
};

/// Noise-free readings of one capture, one per recorded frame. Columns without an instrument are
/// empty.
struct Readings {
  std::vector<double> stress_x, stress_y, stress_shear;  ///< N/m
  std::vector<double> stretch_x, stretch_y;              ///< observed free directions
};

/// Rounds readings to whole multiples of a step; 0 leaves them as they are. A display comes after
/// the noise, so measure() leaves it to whoever adds that.
void show_in_steps(double step, std::vector<double>& readings);

/// Runs the plan. `substeps` small steps per frame interval (more where the clock demands it).
/// `capture_index` is the place of the plan in its suite (a clip slips in capture 0 only).
Readings measure(const PlannedCapture& plan, std::size_t capture_index, const Cloth& cloth,
                 const Faults& faults, int substeps = 20);

}  // namespace tenter::twin
