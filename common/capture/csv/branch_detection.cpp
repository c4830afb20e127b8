// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/branch_detection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tenter::capture {

namespace {

constexpr double kBandOfRange = 0.01;
constexpr double kLargestBandOfRange = 0.1;
constexpr double kBandOfNoise = 6.0;
constexpr double kHoldCrossings = 30.0;

double range_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

/// Median of |x[i-1] - 2 x[i] + x[i+1]|, as the standard deviation of white noise: /(0.6745 sqrt
/// 6).
double noise_of(const std::vector<double>& x) {
  if (x.size() < 5) return 0.0;
  std::vector<double> second;
  second.reserve(x.size());
  for (std::size_t i = 1; i + 1 < x.size(); ++i)
    second.push_back(std::abs(x[i - 1] - 2.0 * x[i] + x[i + 1]));
  const auto middle = second.begin() + static_cast<std::ptrdiff_t>(second.size() / 2);
  std::nth_element(second.begin(), middle, second.end());
  return *middle / (0.6745 * std::sqrt(6.0));
}

/// The signal with play: it follows only once pushed by half a band. Noise alone does not move it.
std::vector<double> with_play(const std::vector<double>& x, double band) {
  std::vector<double> y(x.size());
  double at = x.front();
  for (std::size_t i = 0; i < x.size(); ++i) {
    at = std::clamp(at, x[i] - band / 2.0, x[i] + band / 2.0);
    y[i] = at;
  }
  return y;
}

/// The speed above which half of the way is covered.
double usual_speed(const std::vector<double>& y, const std::vector<double>& time) {
  std::vector<std::pair<double, double>> steps;  // speed, way
  double way = 0.0;
  for (std::size_t i = 1; i < y.size(); ++i) {
    const double step = std::abs(y[i] - y[i - 1]);
    if (step == 0.0) continue;
    steps.emplace_back(step / (time[i] - time[i - 1]), step);
    way += step;
  }
  std::sort(steps.begin(), steps.end());
  double covered = 0.0;
  for (const auto& [speed, step] : steps) {
    covered += step;
    if (covered >= way / 2.0) return speed;
  }
  return 0.0;
}

/// Marks maximal stretches of frames that stay within a band for at least `duration`.
void mark_holds(const std::vector<double>& x, const std::vector<double>& time, double band,
                double duration, std::vector<Branch>* branch) {
  std::size_t begin = 0;
  while (begin < x.size()) {
    double low = x[begin];
    double high = x[begin];
    std::size_t end = begin + 1;
    while (end < x.size()) {
      low = std::min(low, x[end]);
      high = std::max(high, x[end]);
      if (high - low > band) break;
      ++end;
    }
    if (end - begin >= 3 && time[end - 1] - time[begin] >= duration) {
      std::fill(branch->begin() + static_cast<std::ptrdiff_t>(begin),
                branch->begin() + static_cast<std::ptrdiff_t>(end), Branch::hold);
      begin = end;
    } else {
      ++begin;
    }
  }
}

/// Load and unload in the moving frames [begin, end), by turning points with hysteresis.
void mark_motion(const std::vector<double>& x, std::size_t begin, std::size_t end, double band,
                 std::vector<Branch>* branch) {
  std::size_t extreme = begin;  // the frame of the last extreme in the present direction
  std::size_t from = begin;     // where the present branch starts
  int direction = 0;            // 0: not yet known
  std::size_t lowest = begin;
  std::size_t highest = begin;
  const auto fill = [&](std::size_t until) {
    std::fill(branch->begin() + static_cast<std::ptrdiff_t>(from),
              branch->begin() + static_cast<std::ptrdiff_t>(until),
              direction >= 0 ? Branch::load : Branch::unload);
    from = until;
  };
  for (std::size_t i = begin; i < end; ++i) {
    if (direction == 0) {
      if (x[i] < x[lowest]) lowest = i;
      if (x[i] > x[highest]) highest = i;
      if (x[i] - x[lowest] > band)
        direction = 1;
      else if (x[highest] - x[i] > band)
        direction = -1;
      else
        continue;
      extreme = i;
      continue;
    }
    if (direction * (x[i] - x[extreme]) >= 0.0) {
      extreme = i;
    } else if (direction * (x[extreme] - x[i]) > band) {
      fill(extreme + 1);
      direction = -direction;
      extreme = i;
    }
  }
  if (direction == 0) direction = x[end - 1] >= x[begin] ? 1 : -1;
  fill(end);
}

/// Distance of two points, or the channel, frame by frame; the last reading where one is missing.
std::vector<double> measured(const Capture& capture, const AxisState& axis, std::size_t begin,
                             std::size_t end) {
  std::vector<double> values(end - begin, 0.0);
  if (axis.source == AxisState::Source::channel) {
    if (const Channel* channel = capture.find(axis.channel))
      std::copy(channel->values.begin() + static_cast<std::ptrdiff_t>(begin),
                channel->values.begin() + static_cast<std::ptrdiff_t>(end), values.begin());
  } else {
    for (const Channel& a : capture.channels)
      for (const Channel& b : capture.channels)
        if (a.quantity == Quantity::position && b.quantity == Quantity::position &&
            a.point == axis.point_a && b.point == axis.point_b && a.coordinate == b.coordinate)
          for (std::size_t i = begin; i < end; ++i)
            values[i - begin] = std::hypot(values[i - begin], a.values[i] - b.values[i]);
  }
  const auto first =
      std::find_if(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  double last = first == values.end() ? 0.0 : *first;
  for (double& value : values) value = last = std::isfinite(value) ? value : last;
  return values;
}

}  // namespace

std::vector<Branch> detect_branches(const std::vector<double>& driving,
                                    const std::vector<double>& time) {
  const std::size_t n = driving.size();
  std::vector<Branch> branch(n, Branch::hold);
  if (n == 0) return branch;
  const double range = range_of(driving);
  if (n < 3 || !(range > 0.0)) {
    if (range > 0.0)
      std::fill(branch.begin(), branch.end(),
                driving.back() > driving.front() ? Branch::load : Branch::unload);
    return branch;
  }
  const double band = std::min(kLargestBandOfRange * range,
                               std::max(kBandOfRange * range, kBandOfNoise * noise_of(driving)));
  std::vector<double> clock = time;
  if (clock.empty()) {
    clock.resize(n);
    std::iota(clock.begin(), clock.end(), 0.0);
  }
  const double speed = usual_speed(with_play(driving, band), clock);
  std::fill(branch.begin(), branch.end(), Branch::other);
  if (speed > 0.0) mark_holds(driving, clock, band, kHoldCrossings * band / speed, &branch);
  for (std::size_t begin = 0; begin < n;) {
    std::size_t end = begin + 1;
    while (end < n && (branch[end] == Branch::hold) == (branch[begin] == Branch::hold)) ++end;
    if (branch[begin] != Branch::hold) mark_motion(driving, begin, end, band, &branch);
    begin = end;
  }
  return branch;
}

std::vector<double> driving_component(const Capture& capture, std::size_t begin, std::size_t end) {
  const Kinematics& k = capture.kinematics;
  for (const AxisState::Role role : {AxisState::Role::prescribed, AxisState::Role::observed}) {
    std::vector<double> best;
    double best_share = -1.0;
    for (const AxisState* axis : {&k.x, &k.xy, &k.y}) {
      if (axis->role != role || axis->source == AxisState::Source::none) continue;
      std::vector<double> values = measured(capture, *axis, begin, end);
      const Channel* channel =
          axis->source == AxisState::Source::channel ? capture.find(axis->channel) : nullptr;
      // lengths move relative to themselves, strains and displacements by what they are
      const bool is_length = !channel || channel->quantity == Quantity::length;
      double scale = is_length ? std::abs(values.front()) : 1.0;
      if (channel && channel->quantity == Quantity::displacement && axis->reference_length_m > 0.0)
        scale = axis->reference_length_m;
      const double share = range_of(values) / (scale > 0.0 ? scale : 1.0);
      if (share > best_share) {
        best_share = share;
        best = std::move(values);
      }
    }
    if (!best.empty()) return best;
  }
  return {};
}

}  // namespace tenter::capture
