// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/knit/knit_places.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

#include "server/estimation/sequences/material_location.h"

namespace tenter::bench {
namespace {

using estimation::Sequence;

constexpr int kSteps = 3;             // of Gauss-Newton; the map is nearly linear
constexpr double kDifference = 1e-4;  // m, for its slope
constexpr double kMargin = 1e-3;      // m, from the edges of the cloth

Eigen::Vector2d shown(const Sequence& s, const mechanics::State& state,
                      const Eigen::Vector2d& place_m) {
  const auto location = estimation::locate(s.cloth.mesh, place_m);
  return location->position(state.x).head<2>();
}

Eigen::Matrix2d slope(const Sequence& s, const mechanics::State& state,
                      const Eigen::Vector2d& place_m) {
  Eigen::Matrix2d result;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kDifference * Eigen::Vector2d::Unit(axis);
    result.col(axis) =
        (shown(s, state, place_m + step) - shown(s, state, place_m - step)) / (2.0 * kDifference);
  }
  return result;
}

Eigen::Vector2d mean_measured(const Sequence& s, std::size_t frame, int pin,
                              const std::vector<int>& fitted) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const int pull : fitted) sum += s.frames[frame].points_m.col(kPins * pull + pin).head<2>();
  return sum / static_cast<double>(fitted.size());
}

}  // namespace

void place_pins(const std::vector<mechanics::State>& states, const std::vector<int>& fitted,
                int left_out, KnitData& data) {
  Sequence& s = data.sequence;
  const Eigen::Vector2d most =
      s.cloth.mesh.material_m.rowwise().maxCoeff() - Eigen::Vector2d::Constant(kMargin);
  const auto move_to = [&](int pin, Eigen::Vector2d place) {
    place = place.cwiseMin(most).cwiseMax(kMargin);
    for (int pull = 0; pull < data.pulls; ++pull)
      s.points[static_cast<std::size_t>(kPins * pull + pin)].material_m = place;
  };
  const auto place_of = [&](int pin) { return s.points[static_cast<std::size_t>(pin)].material_m; };
  const auto frames = static_cast<Eigen::Index>(states.size());
  for (int step = 0; step < kSteps; ++step) {
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * kPins * frames, 2 * kPins + 1);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(a.rows());
    for (int pin = 0; pin < kPins; ++pin)
      for (Eigen::Index f = 0; f < frames; ++f) {
        if (pin == left_out) continue;
        const auto k = static_cast<std::size_t>(f);
        const Eigen::Index row = 2 * (pin * frames + f);
        a.block<2, 2>(row, 2 * pin) = slope(s, states[k], place_of(pin));
        a(row + 1, 2 * kPins) = -1.0;
        b.segment<2>(row) = mean_measured(s, k, pin, fitted) - shown(s, states[k], place_of(pin));
      }
    // of a pin that is left out the columns are zero, and so is its step
    const Eigen::VectorXd change = a.completeOrthogonalDecomposition().solve(b);
    for (int pin = 0; pin < kPins; ++pin)
      if (pin != left_out) move_to(pin, place_of(pin) + change.segment<2>(2 * pin));
    data.offset_m += change[2 * kPins];
    for (auto& frame : s.frames) frame.points_m.row(1).array() += change[2 * kPins];
    if (left_out < 0) continue;
    const mechanics::State& taut = states[kTautFrame];
    move_to(left_out, place_of(left_out) + slope(s, taut, place_of(left_out)).inverse() *
                                               (mean_measured(s, kTautFrame, left_out, fitted) -
                                                shown(s, taut, place_of(left_out))));
  }
}

}  // namespace tenter::bench
