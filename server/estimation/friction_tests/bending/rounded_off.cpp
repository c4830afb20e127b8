// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/rounded_off.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tenter::estimation {
namespace {

constexpr int kFewestCells = 600;

/// Length of a chord over that of its arc, which turns by `angle`.
double chord_share(double angle) {
  return std::abs(angle) < 1e-6 ? 1.0 : std::sin(0.5 * angle) / (0.5 * angle);
}

double at(const Eigen::VectorXd& borders, double cell, double arc) {
  const auto last = static_cast<int>(borders.size()) - 2;
  const int i = std::clamp(static_cast<int>(arc / cell), 0, last);
  const double share = arc / cell - i;
  return (1.0 - share) * borders[i] + share * borders[i + 1];
}

}  // namespace

int rounding_cells(const ProfileSamples& profile) {
  const int between = std::max(1, static_cast<int>(profile.points.size()) - 1);
  return between * ((kFewestCells + between - 1) / between);
}

std::optional<RoundedOff> rounded_off(const ProfileSamples& profile,
                                      const Eigen::VectorXd& strain) {
  const int cells = static_cast<int>(strain.size());
  const double length = profile.curve.length_m();
  const double cell = length / cells;
  const int stride = cells / std::max(1, static_cast<int>(profile.points.size()) - 1);
  Eigen::VectorXd direction(cells + 1), torque(cells + 1), drop(cells);
  std::vector<ContourPoint> points;
  ContourPoint place = profile.curve.position(0.0);
  direction[0] = profile.curve.direction(0.0);
  points.push_back(place);
  for (int i = 0; i < cells; ++i) {
    const double turn = strain[i] / 3.0 * cell;
    const double middle = direction[i] + 0.5 * turn;
    const double chord = cell * chord_share(turn);
    direction[i + 1] = direction[i] + turn;
    place = {place.x_m + chord * std::cos(middle), place.y_m + chord * std::sin(middle)};
    drop[i] = profile.weight_N_m2 * (length - (i + 0.5) * cell) * chord * std::cos(middle);
    if ((i + 1) % stride == 0) points.push_back(place);
  }
  torque[cells] = 0.0;
  for (int i = cells; i-- > 0;) torque[i] = torque[i + 1] - drop[i];

  const auto curve =
      ProfileCurve::fitted(points, {.length_m = length, .intervals = profile.intervals});
  if (!curve) return std::nullopt;
  const auto samples = static_cast<Eigen::Index>(profile.samples.size());
  RoundedOff off{Eigen::VectorXd(samples), Eigen::VectorXd(samples * kTorquesPerSample)};
  for (Eigen::Index k = 0; k < samples; ++k) {
    const TorqueSample& sample = profile.samples[static_cast<std::size_t>(k)];
    const double lo = sample.arc_m - 0.5 * profile.width_m;
    const double hi = lo + profile.width_m;
    off.strain[k] = 3.0 * (curve->direction(hi) - curve->direction(lo)) / profile.width_m;
    for (int q = 0; q < kTorquesPerSample; ++q) {
      const double arc = lo + (q + 0.5) / kTorquesPerSample * profile.width_m;
      const int i = std::clamp(static_cast<int>(arc / cell), 0, cells - 1);
      off.strain[k] -= strain[i] / kTorquesPerSample;
      off.torque[k * kTorquesPerSample + q] =
          curve->torque(arc, profile.weight_N_m2) - at(torque, cell, arc);
    }
  }
  return off;
}

}  // namespace tenter::estimation
