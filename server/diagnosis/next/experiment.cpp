// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/next/experiment.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tenter::diagnosis {
namespace {

constexpr int kFrames = 20;

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[96];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// Frames one after the other, with all that Curves keeps of each.
class Recorder {
 public:
  Recorder(const estimation::Curves& like, int component, estimation::Curves& curves)
      : component_(component), curves_(curves) {
    q_ = like.path.q.front();
    place(0.0, 0.0, mechanics::FrameStart::virgin);
  }

  void ramp(const ExperimentStep& step) {
    const double from = strain_;
    const double seconds = std::abs(step.strain - from) / step.rate_per_s;
    const bool loads = std::abs(step.strain) > std::abs(from);
    begin(loads ? capture::Branch::load : capture::Branch::unload);
    for (int k = 1; k <= kFrames; ++k)
      place(from + (step.strain - from) * k / kFrames, seconds / kFrames,
            mechanics::FrameStart::next);
  }

  /// Denser at its beginning, where a relaxation shows.
  void hold(const ExperimentStep& step) {
    begin(capture::Branch::hold);
    for (int k = 1; k <= kFrames; ++k)
      place(strain_, step.seconds * (2.0 * k - 1.0) / (kFrames * kFrames),
            mechanics::FrameStart::next);
  }

 private:
  double rest() const { return component_ == 2 ? 0.0 : 1.0; }

  void begin(capture::Branch branch) {
    const int here = static_cast<int>(curves_.path.q.size());
    // the first frame, at rest, belongs to the first branch
    curves_.blocks.push_back({0, branch, curves_.blocks.empty() ? 0 : here, here});
  }

  void place(double strain, double seconds, mechanics::FrameStart start) {
    strain_ = strain;
    clock_ += seconds;
    q_[component_] = rest() + strain;
    const int number = static_cast<int>(curves_.path.q.size());
    curves_.path.q.push_back(q_);
    curves_.path.duration_s.push_back(seconds);
    curves_.path.start.push_back(start);
    curves_.clock_s.push_back(clock_);
    curves_.frame.push_back(number + 1);
    curves_.origin.push_back(number);
    curves_.block_of.push_back(
        curves_.blocks.empty() ? 0 : static_cast<int>(curves_.blocks.size()) - 1);
    if (!curves_.blocks.empty()) curves_.blocks.back().last = number + 1;
  }

  int component_;
  estimation::Curves& curves_;
  Eigen::Vector3d q_;
  double strain_ = 0.0;
  double clock_ = 0.0;
};

std::string percent(double share) {
  return formatted("%.3g %%", 100.0 * share);
}

}  // namespace

ExperimentStep ramp_to(double strain, double rate_per_s) {
  return {false, strain, rate_per_s, 0.0};
}

ExperimentStep hold_for(double seconds) {
  return {true, 0.0, 0.0, seconds};
}

double Experiment::duration_s() const {
  double total = 0.0;
  double at = 0.0;
  for (const ExperimentStep& step : steps) {
    total += step.is_hold ? step.seconds : std::abs(step.strain - at) / step.rate_per_s;
    if (!step.is_hold) at = step.strain;
  }
  return total;
}

double Experiment::largest_strain() const {
  double largest = 0.0;
  for (const ExperimentStep& step : steps) largest = std::max(largest, std::abs(step.strain));
  return largest;
}

bool Experiment::splits_rate() const {
  double slowest = 1e300;
  double fastest = 0.0;
  for (const ExperimentStep& step : steps) {
    if (step.is_hold) return true;
    slowest = std::min(slowest, step.rate_per_s);
    fastest = std::max(fastest, step.rate_per_s);
  }
  return fastest >= 3.0 * slowest;
}

estimation::Curves curves_of(const Experiment& plan, const estimation::Curves& like) {
  estimation::Curves curves;
  curves.id = "next";
  curves.title = plan.name;
  curves.path.axis_angle_rad = like.path.axis_angle_rad;
  curves.path.is_free = like.path.is_free;
  curves.time_base = estimation::TimeBase::clock;
  Recorder recorder(like, plan.component, curves);
  for (const ExperimentStep& step : plan.steps)
    step.is_hold ? recorder.hold(step) : recorder.ramp(step);
  const std::size_t frames = curves.frame_count();
  curves.runs.push_back({1, plan.name, 0, static_cast<int>(frames)});
  for (estimation::ObservedChannel channel : like.channels) {
    channel.measured.assign(frames, 0.0);
    channel.sigma_per_frame.clear();
    curves.channels.push_back(std::move(channel));
  }
  return curves;
}

const char* name_of_component(const Experiment& plan) {
  return plan.component == kWayOfClips ? "clips" : estimation::component_name(plan.component);
}

std::vector<std::string> words_of(const Experiment& plan) {
  std::vector<std::string> words;
  double at = 0.0;
  for (const ExperimentStep& step : plan.steps) {
    if (step.is_hold) {
      words.push_back("hold at " + percent(at) + formatted(" for %.3g s", step.seconds));
      continue;
    }
    words.push_back(std::string(name_of_component(plan)) + " from " + percent(at) + " to " +
                    percent(step.strain) + " at " + percent(step.rate_per_s) + " a second");
    at = step.strain;
  }
  return words;
}

}  // namespace tenter::diagnosis
