// SPDX-License-Identifier: GPL-3.0-or-later
// Time steps one after the other until a given instant, with a length that is fixed, or follows
// the estimated error of each step:
//
//   dt <- dt min(2, max(0.3, 0.9 (error_m / estimate)^(1/(order + 1))))
//
//   StepLength length{.largest_s = 0.02, .error_m = 1e-5};
//   auto end = walk_until(stepper, parameters, script, 1.0, options, length, motion);
//
// A step that fails is tried again with half of its length, down to the smallest. The script says
// what holds at an instant: loads, prescribed clips, obstacles. Uses the stepper's thread.
#pragma once

#include <functional>
#include <string>

#include "server/mechanics/dynamics/step.h"

namespace tenter::mechanics {

/// What holds at time_s; the duration is filled in by the walk.
using Script = std::function<StepInput(double time_s)>;

struct StepLength {
  double largest_s = 0.01;
  double smallest_s = 1e-7;
  double error_m = 0.0;  ///< of one step; 0: every step is the largest that gets there
  double next_s = 0.0;   ///< of the next step, kept from walk to walk; 0: begin with the largest
};

struct WalkEnd {
  enum class How {
    complete,
    too_small,  ///< a step of the smallest length fails
    stopped     ///< by a hook
  };
  How how = How::complete;
  std::string reason;  ///< one sentence, where a step failed
  int steps = 0;
  int rejected = 0;  ///< steps that failed or whose error was too large
  int iterations = 0;
  int factorisations = 0;
  double error_m = 0.0;     ///< sum of the estimates of all steps
  double shortest_s = 0.0;  ///< step that was taken
  double work_J = 0.0;      ///< done by who moves the prescribed clips
  StepResult last;
};

struct WalkHooks {
  std::function<bool()> go_on;                 ///< asked before every step; empty: always
  std::function<bool(const Motion&)> on_step;  ///< after every step that was taken; false stops
};

/// bad_input as TimeStepper::step, and for lengths that are not positive or an end before the
/// motion's time.
Expected<WalkEnd> walk_until(TimeStepper& stepper, const Eigen::VectorXd& parameters,
                             const Script& script, double until_s, const StepOptions& options,
                             StepLength& length, Motion& motion, const WalkHooks& hooks = {});

}  // namespace tenter::mechanics
