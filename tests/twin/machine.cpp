// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/machine.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tenter::twin {
namespace {

constexpr double kLongestStep = 0.25;  // s, where the cloth has rates
constexpr int kMostSteps = 400;

/// Stress against wall clock in small steps, for instruments whose clock is not the frames' clock.
struct Trace {
  std::vector<double> time;
  std::vector<Nominal> stress;

  Nominal at(double t) const {
    if (t <= time.front()) return stress.front();
    if (t >= time.back()) return stress.back();
    const auto upper = std::upper_bound(time.begin(), time.end(), t);
    const auto i = static_cast<std::size_t>(upper - time.begin());
    const double w = (t - time[i - 1]) / (time[i] - time[i - 1]);
    const Nominal &a = stress[i - 1], &b = stress[i];
    return {a.x + w * (b.x - a.x), a.y + w * (b.y - a.y), a.shear + w * (b.shear - a.shear)};
  }
};

/// What the grips really do to the swatch when the machine reports a strain.
class Grips {
 public:
  Grips(const Faults& faults, std::size_t capture_index)
      : faults_(faults), slips_here_(capture_index == 0 && faults.slip_strain != 0.0) {}

  Deformation swatch(double strain_x, double strain_y, double shear, double time, int run,
                     std::size_t frame) {
    if (faults_.backlash_strain != 0.0) {
      play_[0] = std::clamp(play_[0], strain_x - faults_.backlash_strain, strain_x);
      play_[1] = std::clamp(play_[1], strain_y - faults_.backlash_strain, strain_y);
      strain_x = play_[0];
      strain_y = play_[1];
    }
    if (slips_here_ && run == faults_.slip_run && frame >= faults_.slip_frame)
      strain_x -= faults_.slip_strain;
    if (faults_.expansion_strain != 0.0) {
      const double turn = 2.0 * std::numbers::pi * time / faults_.expansion_period_s;
      const double grown =
          faults_.expansion_strain *
          (std::sin(turn + faults_.expansion_phase_rad) - std::sin(faults_.expansion_phase_rad));
      strain_x -= grown;
      strain_y -= grown;
    }
    return {1.0 + strain_x, 1.0 + strain_y, shear};
  }

 private:
  const Faults& faults_;
  bool slips_here_;
  std::array<double, 2> play_ = {0.0, 0.0};
};

/// Which way each cord went last: +1 pulled, -1 let back, 0 never moved.
class Cords {
 public:
  void move_to(const PlannedFrame& frame, const PlannedFrame& before) {
    turn(0, frame.strain_x - before.strain_x);
    turn(1, frame.strain_y - before.strain_y);
  }
  double shown(const Faults& faults, std::size_t cord, double tension) const {
    return tension * (1.0 + faults.cord_friction[cord] * way_[cord]);
  }

 private:
  void turn(std::size_t cord, double travel) {
    if (travel != 0.0) way_[cord] = travel > 0.0 ? 1.0 : -1.0;
  }
  std::array<double, 2> way_ = {0.0, 0.0};
};

/// What a cell makes of the force on it.
double cell_reading(const Faults& faults, std::size_t cell, double force, double elapsed_s) {
  const double value =
      faults.gain[cell] * force + faults.offset_N_m[cell] + faults.drift_N_m_s[cell] * elapsed_s;
  return std::min(value, faults.cap_N_m[cell]);
}

bool one_step_is_enough(const Cloth& cloth, const Faults& faults) {
  return !cloth.remembers() && faults.backlash_strain == 0.0 && faults.expansion_strain == 0.0 &&
         faults.force_delay_s == 0.0 && faults.clock_alias_s == 0.0;
}

void misread(const Faults& faults, std::size_t capture_index, int cell,
             std::vector<double>& stress) {
  if (faults.outlier_N_m == 0.0) return;
  Random places(stream_seed(
      faults.outlier_seed + 2 * capture_index + static_cast<std::size_t>(cell), "outliers"));
  for (double& value : stress) {
    const bool hit = places.uniform() < faults.outlier_share;
    const double height = places.sign() * places.uniform(0.5, 1.5);
    if (hit) value += faults.outlier_N_m * height;
  }
}

}  // namespace

void show_in_steps(double step, std::vector<double>& readings) {
  if (step <= 0.0) return;
  for (double& value : readings) value = step * std::round(value / step);
}

Readings measure(const PlannedCapture& plan, std::size_t capture_index, const Cloth& cloth,
                 const Faults& faults, int substeps) {
  const std::vector<PlannedFrame>& frames = plan.frames;
  const bool simple = one_step_is_enough(cloth, faults);
  const bool other_clock = faults.force_delay_s != 0.0 || faults.clock_alias_s != 0.0;

  const double factor = cloth.factor_of(plan.specimen);
  Grips grips(faults, capture_index);
  ClothState state;
  Deformation swatch;
  Nominal stress;
  Trace trace;
  std::vector<Nominal> at_frame(frames.size());
  std::vector<Deformation> shape(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const PlannedFrame& to = frames[i];
    const PlannedFrame& from = i > 0 ? frames[i - 1] : to;
    const double dt = to.time_s - from.time_s;
    int count = 1;
    if (i > 0 && !simple)
      count = std::clamp(static_cast<int>(std::ceil(dt / kLongestStep)), substeps, kMostSteps);
    for (int k = 1; k <= count; ++k) {
      const double w = static_cast<double>(k) / count;
      const double time = from.time_s + w * dt;
      const Deformation wanted =
          grips.swatch(from.strain_x + w * (to.strain_x - from.strain_x),
                       from.strain_y + w * (to.strain_y - from.strain_y),
                       from.shear + w * (to.shear - from.shear), time, to.run, i);
      swatch = {plan.free_x ? swatch.x : wanted.x, plan.free_y ? swatch.y : wanted.y, wanted.shear};
      stress = plan.free_x || plan.free_y
                   ? step_free(cloth, plan.angle_rad, plan.free_x, swatch, dt / count, state)
                   : step(cloth, plan.angle_rad, swatch, dt / count, state);
      stress = {factor * stress.x, factor * stress.y, factor * stress.shear};
      if (other_clock) {
        trace.time.push_back(time);
        trace.stress.push_back(stress);
      }
    }
    at_frame[i] = stress;
    shape[i] = swatch;
  }

  Readings readings;
  Cords cords;
  std::size_t recorded = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    cords.move_to(frames[i], i > 0 ? frames[i - 1] : frames[i]);
    if (!frames[i].recorded) continue;
    Nominal read = at_frame[i];
    if (other_clock) {
      const double beat =
          2.0 * std::numbers::pi * faults.clock_alias_frames * static_cast<double>(recorded);
      read =
          trace.at(frames[i].time_s - faults.force_delay_s + faults.clock_alias_s * std::sin(beat));
    }
    ++recorded;
    const double elapsed = frames[i].time_s - frames.front().time_s;
    const auto seen = [&faults](double stretch) {
      return faults.camera_rest + faults.camera_scale * (stretch - faults.camera_rest);
    };
    if (plan.free_x)
      readings.stretch_x.push_back(seen(shape[i].x));
    else
      readings.stress_x.push_back(cell_reading(faults, 0, cords.shown(faults, 0, read.x), elapsed));
    if (plan.free_y)
      readings.stretch_y.push_back(seen(shape[i].y));
    else
      readings.stress_y.push_back(cell_reading(faults, 1, cords.shown(faults, 1, read.y), elapsed));
    if (plan.shears) readings.stress_shear.push_back(read.shear);
  }
  misread(faults, capture_index, 0, readings.stress_x);
  misread(faults, capture_index, 1, readings.stress_y);
  return readings;
}

}  // namespace tenter::twin
