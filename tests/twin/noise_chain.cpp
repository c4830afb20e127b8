// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/noise_chain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tenter::twin {

double add_noise(const NoiseShares& shares, double sigma, const std::vector<int>& run,
                 Random& random, std::vector<double>& readings) {
  if (sigma <= 0.0 || readings.empty()) return 0.0;
  double largest = 0.0, squares = 0.0;
  for (const double value : readings) largest = std::max(largest, std::abs(value));
  const double scale = largest > 0.0 ? 1.0 / largest : 0.0;
  for (const double value : readings) squares += value * value * scale * scale;

  // total variance in units of the shares; a uniform rounding error has variance step^2 / 12
  const double variance =
      shares.white * shares.white + shares.correlated * shares.correlated +
      shares.run_offset * shares.run_offset +
      shares.run_gain * shares.run_gain * squares / static_cast<double>(readings.size()) +
      shares.quantum * shares.quantum / 12.0;
  const double unit = sigma / std::sqrt(variance);
  const double step = unit * shares.quantum;
  const double innovation = std::sqrt(1.0 - shares.correlation * shares.correlation);

  double slow = 0.0, offset = 0.0, gain = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (i == 0 || run[i] != run[i - 1]) {
      slow = random.normal();
      offset = shares.run_offset * random.normal();
      gain = shares.run_gain * random.normal();
    } else {
      slow = shares.correlation * slow + innovation * random.normal();
    }
    const double noise = shares.white * random.normal() + shares.correlated * slow + offset +
                         gain * std::abs(readings[i]) * scale;
    readings[i] += unit * noise;
    if (step > 0.0) readings[i] = step * std::round(readings[i] / step);
  }
  return step;
}

}  // namespace tenter::twin
