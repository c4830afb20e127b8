// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/dynamics/walk.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {
namespace {

constexpr double kSafety = 0.9;
constexpr double kMostGrowth = 2.0;  // below 1 + sqrt 2, where BDF2 stays stable
constexpr double kMostShrinking = 0.3;
constexpr double kSameInstant = 1e-9;  // of a step: what is left of it is rounding

double growth(double wanted_m, double estimate_m, int order) {
  if (!(estimate_m > 0.0)) return kMostGrowth;
  return std::clamp(kSafety * std::pow(wanted_m / estimate_m, 1.0 / (order + 1)), kMostShrinking,
                    kMostGrowth);
}

}  // namespace

Expected<WalkEnd> walk_until(TimeStepper& stepper, const Eigen::VectorXd& parameters,
                             const Script& script, double until_s, const StepOptions& options,
                             StepLength& length, Motion& motion, const WalkHooks& hooks) {
  if (!(length.largest_s > 0.0) || !(length.smallest_s > 0.0) || !(length.error_m >= 0.0))
    return bad_input("lengths of steps must be positive, their error not negative");
  if (!(until_s >= motion.time_s)) return bad_input("the walk ends before it begins");
  WalkEnd end;
  if (length.next_s <= 0.0) length.next_s = length.largest_s;
  StepOptions how = options;
  how.largest_error_m = length.error_m;
  while (until_s - motion.time_s > kSameInstant * length.largest_s) {
    if (hooks.go_on && !hooks.go_on()) {
      end.how = WalkEnd::How::stopped;
      return end;
    }
    // equal parts of what is left, so that no step is a splinter
    const double left_s = until_s - motion.time_s;
    const double wanted_s = std::min(length.next_s, length.largest_s);
    const double parts = std::max(1.0, std::ceil(left_s / wanted_s - 1e-6));
    const double duration_s = left_s / parts;
    StepInput input = script(parts == 1.0 ? until_s : motion.time_s + duration_s);
    input.duration_s = duration_s;
    auto step = stepper.step(parameters, input, motion, how);
    if (!step) return tl::unexpected(step.error());
    end.last = *step;
    end.iterations += end.last.iterations;
    end.factorisations += end.last.factorisations;
    if (end.last.is_good(how)) {
      ++end.steps;
      end.error_m += end.last.error_m;
      end.work_J += end.last.work_J;
      end.shortest_s = end.steps == 1 ? duration_s : std::min(end.shortest_s, duration_s);
      length.next_s = length.error_m > 0.0
                          ? duration_s * growth(length.error_m, end.last.error_m, end.last.order)
                          : std::min(length.largest_s, kMostGrowth * duration_s);
      if (hooks.on_step && !hooks.on_step(motion)) {
        end.how = WalkEnd::How::stopped;
        return end;
      }
      continue;
    }
    ++end.rejected;
    if (duration_s <= length.smallest_s) {
      end.how = WalkEnd::How::too_small;
      end.reason = "a step of " + std::to_string(duration_s) + " s from " +
                   std::to_string(motion.time_s) + " s fails: " + describe(end.last, how);
      return end;
    }
    const bool is_solved = end.last.is_solved(how);
    length.next_s =
        duration_s *
        (is_solved ? std::min(0.9, growth(length.error_m, end.last.error_m, end.last.order)) : 0.5);
    length.next_s = std::max(length.next_s, length.smallest_s);
  }
  return end;
}

}  // namespace tenter::mechanics
