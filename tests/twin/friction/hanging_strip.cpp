// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/friction/hanging_strip.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tests/twin/random.h"

namespace tenter::twin {
namespace {

/// Torque of a hinge that went one way from the rolled strip: a table of small steps.
class OneWay {
 public:
  OneWay(const FrictionSample& sample, double rolled) : step_(sample.tau / 200.0), rolled_(rolled) {
    const FrictionState start = moved(sample, {}, rolled);
    constexpr double kFarthest = 1500.0;  // a radius of 2 mm
    for (const double side : {-1.0, 1.0}) {
      std::vector<double>& torque = side < 0.0 ? down_ : up_;
      FrictionState state = start;
      double extreme = stress(sample, start);
      torque.push_back(extreme);
      while (side * state.strain < kFarthest) {
        state = stepped(sample, state, side * step_);
        const double now = stress(sample, state);
        extreme = side < 0.0 ? std::min(extreme, now) : std::max(extreme, now);
        torque.push_back(extreme);
      }
    }
  }
  struct Value {
    double torque, slope;
  };
  Value at(double strain) const {
    const std::vector<double>& table = strain < rolled_ ? down_ : up_;
    const double x = std::abs(strain - rolled_) / step_;
    const auto i = std::min(static_cast<std::size_t>(x), table.size() - 2);
    const double rise = table[i + 1] - table[i];
    return {table[i] + (x - static_cast<double>(i)) * rise,
            (strain < rolled_ ? -rise : rise) / step_};
  }

 private:
  double step_, rolled_;
  std::vector<double> down_, up_;
};

/// Hinges at the nodes 0 to n - 1; the first, at the clamp, stands for half a segment.
class Chain {
 public:
  Chain(const FrictionSample& sample, const StripPlan& plan)
      : sample_(sample),
        plan_(plan),
        step_m_(plan.length_m / plan.hinges),
        weight_(sample.density_kg_m2 * plan.gravity_m_s2) {
    const double rolled = plan.radius_m > 0.0 ? 3.0 / plan.radius_m : 0.0;
    if (plan.unrolling == Unrolling::one_way) one_way_.emplace(sample, rolled);
    const auto n = static_cast<std::size_t>(plan.hinges);
    state_.assign(n, moved(sample, {}, rolled));
    least_.assign(n, rolled);
    most_.assign(n, rolled);
    points_.resize(n + 1);
    torque_.resize(n + 1);
  }

  /// Places, and the torques of gravity.
  void lay_out() {
    double angle = plan_.clamp_angle_rad;
    const std::size_t n = state_.size();
    for (std::size_t i = 0; i < n; ++i) {
      angle += state_[i].strain / 3.0 * (i == 0 ? 0.5 : 1.0) * step_m_;
      points_[i + 1].x_m = points_[i].x_m + step_m_ * std::cos(angle);
      points_[i + 1].y_m = points_[i].y_m + step_m_ * std::sin(angle);
    }
    double moment = 0.0;  // integral of x over what hangs below
    torque_[n] = 0.0;
    for (std::size_t i = n; i-- > 0;) {
      moment += 0.5 * (points_[i].x_m + points_[i + 1].x_m) * step_m_;
      const double below = static_cast<double>(n - i) * step_m_;
      torque_[i] = -weight_ * (moment - below * points_[i].x_m);
    }
  }

  /// One step of creeping; the largest torque that is missing.
  double creep(double pace) {
    lay_out();
    double largest = 0.0;
    double fastest = 0.0;
    wanted_.resize(state_.size());
    for (std::size_t i = 0; i < state_.size(); ++i) {
      const FrictionState& s = state_[i];
      double missing = torque_[i];
      double tangent = 0.0;
      if (one_way_) {
        const OneWay::Value value = one_way_->at(s.strain);
        missing -= value.torque;
        tangent = value.slope;
      } else {
        missing -= stress(sample_, s);
        const double sign = missing > 0.0 ? 1.0 : -1.0;
        const double size = std::abs(s.strain);
        tangent = sample_.k1 + 2.0 * sample_.k2 * size +
                  (sample_.a + sample_.b * size - sign * s.friction) / sample_.tau;
      }
      wanted_[i] = pace * missing / (1.0 + pace * std::max(tangent, 0.0));
      largest = std::max(largest, std::abs(missing));
      fastest = std::max(fastest, std::abs(wanted_[i]));
    }
    const double share = std::min(1.0, 0.05 * sample_.tau / std::max(fastest, 1e-300));
    for (std::size_t i = 0; i < state_.size(); ++i) {
      if (one_way_)
        state_[i].strain += share * wanted_[i];
      else
        state_[i] = stepped(sample_, state_[i], share * wanted_[i]);
      least_[i] = std::min(least_[i], state_[i].strain);
      most_[i] = std::max(most_[i], state_[i].strain);
    }
    return largest;
  }

  RestingStrip rest() {
    // gravity answers a change of curvature with at most about this much torque
    const double gravity = weight_ * std::pow(plan_.length_m, 3.0) / 3.0;
    const double pace = 0.5 / gravity;
    const double small = 1e-5 * (sample_.a + sample_.b * 30.0);
    RestingStrip strip;
    constexpr int kMaxSteps = 400000;
    for (int i = 0; i < kMaxSteps && !strip.is_at_rest; ++i) strip.is_at_rest = creep(pace) < small;
    lay_out();
    strip.length_m = plan_.length_m;
    strip.points = points_;
    strip.torque_N = torque_;
    for (std::size_t i = 0; i < state_.size(); ++i) {
      strip.strain.push_back(state_[i].strain);
      const double rolled = plan_.radius_m > 0.0 ? 3.0 / plan_.radius_m : 0.0;
      const bool unrolled = state_[i].strain < rolled;
      strip.way_back.push_back(unrolled ? state_[i].strain - least_[i]
                                        : most_[i] - state_[i].strain);
    }
    strip.strain.push_back(strip.strain.back());
    strip.way_back.push_back(strip.way_back.back());
    return strip;
  }

 private:
  const FrictionSample& sample_;
  const StripPlan& plan_;
  double step_m_;
  double weight_;
  std::optional<OneWay> one_way_;
  std::vector<FrictionState> state_;
  std::vector<double> least_, most_, torque_, wanted_;
  std::vector<StripPoint> points_;
};

}  // namespace

RestingStrip resting_strip(const FrictionSample& sample, const StripPlan& plan) {
  return Chain(sample, plan).rest();
}

std::vector<StripPoint> photographed(const RestingStrip& strip, double noise_m,
                                     std::uint64_t seed) {
  Random noise(stream_seed(seed, "contour"));
  std::vector<StripPoint> points = strip.points;
  for (StripPoint& point : points) {
    point.x_m += noise_m * noise.normal();
    point.y_m += noise_m * noise.normal();
  }
  return points;
}

double cantilever_length(const FrictionSample& sample) {
  StripPlan plan;
  plan.clamp_angle_rad = kCantileverAngle;
  plan.hinges = 60;
  double lo = 0.01;
  double hi = 0.3;
  constexpr int kHalvings = 10;
  for (int i = 0; i < kHalvings; ++i) {
    plan.length_m = 0.5 * (lo + hi);
    const StripPoint tip = resting_strip(sample, plan).points.back();
    const double fall = std::atan2(-tip.y_m, -tip.x_m) * 57.29577951308232;
    (fall < 41.5 ? lo : hi) = plan.length_m;
  }
  return 0.5 * (lo + hi);
}

}  // namespace tenter::twin
