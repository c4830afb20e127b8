// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/suite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace tenter::twin {
namespace {

using capture::Branch;

constexpr double kFrameStep = 0.004;       // strain between frames
constexpr double kSlowRate = 0.001;        // 1/s
constexpr double kFastRate = 0.01;         // 1/s
constexpr double kSingleRate = 0.003;      // 1/s
constexpr double kRestBetweenRuns = 30.0;  // s
constexpr double kHold = 60.0;             // s
constexpr std::array<double, 4> kNested = {0.02, 0.04, 0.06, 0.08};

/// Direction of a path in (strain_x, strain_y, shear); paths are amplitudes along it.
struct Direction {
  double x = 0.0, y = 0.0, xy = 0.0;
};

/// Writes the frames of one capture, run after run.
class Planner {
 public:
  Planner(PlannedCapture capture, Direction direction, double jitter, Random& choices)
      : capture_(std::move(capture)), direction_(direction), jitter_(jitter), choices_(choices) {}

  int phase(const std::string& name, const std::string& kind, double rate) {
    capture_.phases.push_back({name, kind, rate > 0.0 ? std::optional(rate) : std::nullopt});
    return static_cast<int>(capture_.phases.size()) - 1;
  }

  void begin_run(const std::string& group, int phase) {
    if (!capture_.runs.empty()) clock_ += kRestBetweenRuns;
    capture_.runs.push_back({static_cast<int>(capture_.runs.size()) + 1, group});
    place(clock_, 0.0, phase, Branch::load, true);
  }

  void ramp(double target, double rate, int phase, bool recorded = true) {
    const double from = amplitude_;
    const double length = std::abs(target - from);
    const Branch branch = std::abs(target) > std::abs(from) ? Branch::load : Branch::unload;
    const int count = std::max(4, static_cast<int>(std::ceil(length / kFrameStep - 1e-9)));
    const double start = clock_;
    for (int k = 1; k <= count; ++k) {
      const double shift = k < count ? jitter_ * (choices_.uniform() - 0.5) : 0.0;
      const double share = (k + shift) / count;
      place(start + share * length / rate, from + share * (target - from), phase, branch, recorded);
    }
  }

  void hold(double seconds, int phase) {
    // denser at the start, where a relaxation shows
    const int count = 20;
    const double start = clock_;
    for (int k = 1; k <= count; ++k) {
      const double share = static_cast<double>(k) / count;
      place(start + seconds * share * share, amplitude_, phase, Branch::hold, true);
    }
  }

  void nested_loops(double scale, double rate, int phase) {
    for (const double peak : kNested) {
      ramp(scale * peak, rate, phase);
      ramp(0.0, rate, phase);
    }
  }

  void loop(double peak, double rate, int phase) {
    ramp(peak, rate, phase);
    ramp(0.0, rate, phase);
  }

  PlannedCapture take() { return std::move(capture_); }

 private:
  void place(double time, double amplitude, int phase, Branch branch, bool recorded) {
    clock_ = time;
    amplitude_ = amplitude;
    capture_.frames.push_back(
        {time, amplitude * direction_.x, amplitude * direction_.y, amplitude * direction_.xy,
         static_cast<int>(capture_.runs.size()) - 1, phase, branch, recorded});
  }

  PlannedCapture capture_;
  Direction direction_;
  double jitter_;
  Random& choices_;
  double clock_ = 0.0;
  double amplitude_ = 0.0;
};

/// Which of the loops a suite runs, and how fast.
struct Pace {
  double slow;
  double fast;  ///< 0: one rate only, and no hold
};

PlannedCapture nested_strip(PlannedCapture capture, Direction direction, Pace pace,
                            int slow_repeats, int fast_repeats, int holds, double jitter,
                            Random& choices) {
  Planner plan(std::move(capture), direction, jitter, choices);
  const int slow = plan.phase("nested loops", "cycle", pace.slow);
  for (int r = 0; r < slow_repeats; ++r) {
    plan.begin_run("nested", slow);
    plan.nested_loops(1.0, pace.slow, slow);
  }
  if (pace.fast <= 0.0) return plan.take();
  const int fast = plan.phase("nested loops, fast", "cycle", pace.fast);
  for (int r = 0; r < fast_repeats; ++r) {
    plan.begin_run("nested_fast", fast);
    plan.nested_loops(1.0, pace.fast, fast);
  }
  const int pull = plan.phase("pull before the hold", "ramp", pace.fast);
  const int hold = plan.phase("hold at 6 %", "hold", 0.0);
  const int back = plan.phase("return after the hold", "ramp", pace.fast);
  for (int r = 0; r < holds; ++r) {
    plan.begin_run("hold", pull);
    plan.ramp(0.06, pace.fast, pull);
    plan.hold(kHold, hold);
    plan.ramp(0.0, pace.fast, back);
  }
  return plan.take();
}

PlannedCapture plain_loops(PlannedCapture capture, Direction direction, double peak, Pace pace,
                           int slow_repeats, int fast_repeats, double jitter, Random& choices) {
  Planner plan(std::move(capture), direction, jitter, choices);
  const int slow = plan.phase("loop", "cycle", pace.slow);
  for (int r = 0; r < slow_repeats; ++r) {
    plan.begin_run("loop", slow);
    plan.loop(peak, pace.slow, slow);
  }
  if (pace.fast <= 0.0) return plan.take();
  const int fast = plan.phase("loop, fast", "cycle", pace.fast);
  for (int r = 0; r < fast_repeats; ++r) {
    plan.begin_run("loop_fast", fast);
    plan.loop(peak, pace.fast, fast);
  }
  return plan.take();
}

PlannedCapture named(const std::string& name) {
  PlannedCapture capture;
  capture.name = name;
  return capture;
}

std::vector<PlannedCapture> loops_suite(Pace pace, double jitter, Random& choices) {
  std::vector<PlannedCapture> captures;
  captures.push_back(nested_strip(named("strip_x"), {.x = 1.0}, pace, 3, 2, 2, jitter, choices));
  captures.push_back(nested_strip(named("strip_y"), {.y = 1.0}, pace, 2, 1, 1, jitter, choices));

  PlannedCapture pull = named("pull_x");
  pull.free_y = true;
  captures.push_back(plain_loops(std::move(pull), {.x = 1.0}, 0.06, pace, 2, 1, jitter, choices));

  captures.push_back(
      plain_loops(named("equibiaxial"), {.x = 1.0, .y = 1.0}, 0.05, pace, 2, 1, jitter, choices));

  PlannedCapture shear = named("shear");
  shear.shears = true;
  captures.push_back(plain_loops(std::move(shear), {.xy = 1.0}, 0.1, pace, 2, 1, jitter, choices));

  PlannedCapture bias = named("strip_45");
  bias.angle_rad = std::numbers::pi / 4.0;
  captures.push_back(plain_loops(std::move(bias), {.x = 1.0}, 0.06, pace, 2, 1, jitter, choices));
  return captures;
}

std::vector<PlannedCapture> knit_suite(double jitter, Random& choices) {
  std::vector<PlannedCapture> captures;
  for (const bool along_x : {true, false}) {
    PlannedCapture capture = named(along_x ? "pull_x" : "pull_y");
    (along_x ? capture.free_y : capture.free_x) = true;
    Planner plan(std::move(capture), along_x ? Direction{.x = 1.0} : Direction{.y = 1.0}, jitter,
                 choices);
    const int pull = plan.phase("pull", "ramp", kSingleRate);
    for (int r = 0; r < 5; ++r) {
      plan.begin_run("pull", pull);
      plan.ramp(0.1, kSingleRate, pull);
      plan.ramp(0.0, kSingleRate, pull, false);
    }
    captures.push_back(plan.take());
  }
  return captures;
}

std::vector<PlannedCapture> specimens_suite(double jitter, Random& choices) {
  constexpr int kSpecimens = 3;
  constexpr Pace kPace{kSlowRate, kFastRate};
  std::vector<PlannedCapture> captures;
  for (int specimen = 1; specimen <= kSpecimens; ++specimen)
    for (const bool along_x : {true, false}) {
      if (!along_x && specimen == kSpecimens) continue;
      const std::string protocol = along_x ? "strip_x" : "strip_y";
      PlannedCapture capture = named(protocol + "_" + std::to_string(specimen));
      capture.specimen = specimen;
      capture.protocol = protocol;
      captures.push_back(nested_strip(std::move(capture),
                                      along_x ? Direction{.x = 1.0} : Direction{.y = 1.0}, kPace, 2,
                                      0, 1, jitter, choices));
    }
  return captures;
}

}  // namespace

const std::vector<std::string>& suite_names() {
  static const std::vector<std::string> names = {"rich", "single_rate", "no_time", "knit_like",
                                                 "specimens"};
  return names;
}

bool has_specimens(const std::string& suite) {
  return suite == "specimens";
}

Expected<std::vector<PlannedCapture>> plan_suite(const std::string& suite, Random choices) {
  const double jitter = 0.3;
  if (suite == "rich") return loops_suite({kSlowRate, kFastRate}, jitter, choices);
  if (suite == "knit_like") return knit_suite(jitter, choices);
  if (has_specimens(suite)) return specimens_suite(jitter, choices);
  if (suite == "single_rate" || suite == "no_time") {
    std::vector<PlannedCapture> captures = loops_suite({kSingleRate, 0.0}, jitter, choices);
    if (suite == "no_time")
      for (PlannedCapture& capture : captures) {
        capture.has_time = false;
        for (capture::Phase& phase : capture.phases) phase.nominal_rate_per_s.reset();
      }
    return captures;
  }
  return bad_input("there is no twin suite '" + suite +
                   "' (rich, single_rate, no_time, knit_like, specimens)");
}

}  // namespace tenter::twin
