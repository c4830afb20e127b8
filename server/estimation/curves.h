// SPDX-License-Identifier: GPL-3.0-or-later
// A capture as the estimator sees it: the strain path that drives the model and the observations
// that it must meet.
//
// Observed are the nominal membrane stresses (N/m) of the components that a force-like channel is
// assigned to, and the stretches of free directions that were measured. Force becomes N/m by the
// specimen's width, stress by its thickness.
//
//   block  frames whose errors belong together: one branch (loading, unloading, hold) of one run.
//   The unit of counting,
//          of splitting and of bootstrapping.
//
// Frames in which an imposed strain is missing are dropped and counted.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "server/mechanics/material_point.h"

namespace tenter::estimation {

/// One observed channel of one capture. Per-frame vectors have one entry per kept frame.
struct ObservedChannel {
  std::string name;       ///< "stress_x", "stretch_y", ...
  std::string unit;       ///< "N/m" or "1"
  int component = 0;      ///< 0: x, 1: y, 2: xy
  bool is_stress = true;  ///< else a stretch
  double sigma = 0.0;     ///< standard deviation that the capture declares; 0: none
  double resolution = 0.0;
  std::vector<double> measured;         ///< NaN where missing
  std::vector<double> sigma_per_frame;  ///< empty unless the capture has one per frame
};

struct Block {
  int run = 0;  ///< index into Curves::runs
  capture::Branch branch = capture::Branch::other;
  int first = 0;  ///< kept frames [first, last)
  int last = 0;
};

struct CurveRun {
  int number = 1;     ///< as in the source
  std::string group;  ///< runs of one group repeat each other, also across captures
  int first = 0;
  int last = 0;
};

/// What can be said of time: nothing, a declared rate, or a clock.
enum class TimeBase { none, nominal_rate, clock };

struct Curves {
  std::string id;  ///< SHA-256 of the capture
  std::string title;
  std::string specimen;  ///< its name
  std::string protocol;  ///< captures of one name did the same
  mechanics::StrainPath path;
  TimeBase time_base = TimeBase::none;
  std::vector<double>
      clock_s;  ///< session clock, never falling; pseudo-time where there is no time base
  std::vector<int> frame;  ///< number as in the source
  std::vector<int>
      origin;  ///< index of the frame (of the first of them, where thinned) among all kept frames
  std::vector<int> block_of;
  std::vector<Block> blocks;
  std::vector<CurveRun> runs;
  std::vector<ObservedChannel> channels;
  int dropped_frames = 0;
  /// Where frames are means of others: last_motions_of() these, by component; else empty.
  std::array<std::vector<double>, 3> mean_last_motion;

  std::size_t frame_count() const { return path.q.size(); }
};

/// bad_input where the capture holds nothing that a material point can meet.
Expected<Curves> make_curves(const capture::Capture& capture, const std::string& id);

/// +1, -1 or 0 per frame: where the imposed strain of a component last went
/// (instrument/last_motion); between these where a frame is a mean of others.
std::vector<double> last_motions_of(const Curves& curves, int component);

/// Components that move, as a list of letters for messages ("x", "xy").
const char* component_name(int component);

}  // namespace tenter::estimation
