// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/exam/next_capture.h"

#include <algorithm>
#include <cmath>

namespace tenter::exam {
namespace {

constexpr int kFrames = 24;  // of a ramp or hold

/// Frames of one run, step after step.
class Walk {
 public:
  Walk(int component, twin::PlannedCapture& plan) : component_(component), plan_(plan) {
    plan_.runs.push_back({1, plan_.name});
    place(capture::Branch::load, 0, 0.0, 0.0);
  }

  void step(const diagnosis::ExperimentStep& step) {
    const int phase = static_cast<int>(plan_.phases.size());
    if (step.is_hold) {
      plan_.phases.push_back({"hold", "hold", std::nullopt});
      const double from = time_s_;
      for (int k = 1; k <= kFrames; ++k)
        place(capture::Branch::hold, phase, strain_,
              from + step.seconds * std::pow(static_cast<double>(k) / kFrames, 2));
      return;
    }
    plan_.phases.push_back({"ramp", "ramp", step.rate_per_s});
    const double from = strain_;
    const double begun_s = time_s_;
    const auto branch =
        std::abs(step.strain) > std::abs(from) ? capture::Branch::load : capture::Branch::unload;
    const double seconds = std::abs(step.strain - from) / step.rate_per_s;
    for (int k = 1; k <= kFrames; ++k)
      place(branch, phase, from + (step.strain - from) * k / kFrames,
            begun_s + seconds * k / kFrames);
  }

 private:
  void place(capture::Branch branch, int phase, double strain, double time_s) {
    strain_ = strain;
    time_s_ = time_s;
    twin::PlannedFrame frame;
    frame.time_s = time_s;
    frame.phase = phase;
    frame.branch = branch;
    (component_ == 0 ? frame.strain_x : component_ == 1 ? frame.strain_y : frame.shear) = strain;
    plan_.frames.push_back(frame);
  }

  int component_;
  twin::PlannedCapture& plan_;
  double strain_ = 0.0;
  double time_s_ = 0.0;
};

}  // namespace

std::optional<twin::PlannedCapture> planned(const diagnosis::Design& design,
                                            const std::vector<twin::PlannedCapture>& suite) {
  const auto like = std::find_if(suite.begin(), suite.end(), [&](const auto& plan) {
    return design.mounted_as.ends_with(", " + plan.name);
  });
  if (like == suite.end()) return std::nullopt;
  twin::PlannedCapture plan;
  plan.name = "next " + design.plan.name;
  plan.angle_rad = like->angle_rad;
  plan.free_x = like->free_x;
  plan.free_y = like->free_y;
  plan.shears = like->shears;
  Walk walk(design.plan.component, plan);
  for (const diagnosis::ExperimentStep& step : design.plan.steps) walk.step(step);
  return plan;
}

}  // namespace tenter::exam
