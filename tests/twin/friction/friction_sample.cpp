// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/friction/friction_sample.h"

#include <algorithm>
#include <cmath>

namespace tenter::twin {

const std::vector<FrictionSample>& stretch_samples() {
  static const std::vector<FrictionSample> samples = {
      {"cotton", 0.143, 135.6, 64.03, 2.22, 3.16, 0.006},
      {"spandex", 0.157, 4.42, 32.19, 0.40, 4.84, 0.088},
      {"polyester", 0.121, 26.62, 3.64, 2.10, 5.41, 0.031},
  };
  return samples;
}

const std::vector<FrictionSample>& bending_samples() {
  static const std::vector<FrictionSample> samples = {
      {"felt", 0.208, 145.3e-7, 0.15e-7, 5.12e-4, 0.15e-4, 29.9},
      {"doublecloth", 0.255, 62.19e-7, 0.07e-7, 12.84e-4, 0.05e-4, 7.67},
      {"paper", 0.075, 479.7e-7, 0.47e-7, 0.04e-4, 0.64e-4, 10.2},
  };
  return samples;
}

double stress(const FrictionSample& sample, const FrictionState& state) {
  return (sample.k1 + sample.k2 * std::abs(state.strain)) * state.strain + state.friction;
}

FrictionState stepped(const FrictionSample& sample, FrictionState state, double step) {
  const double s = step >= 0.0 ? 1.0 : -1.0;
  const auto slope = [&](double strain, double friction) {
    return (sample.a + sample.b * std::abs(strain) - s * friction) / sample.tau;
  };
  const double e = state.strain;
  const double f = state.friction;
  const double k1 = slope(e, f);
  const double k2 = slope(e + 0.5 * step, f + 0.5 * step * k1);
  const double k3 = slope(e + 0.5 * step, f + 0.5 * step * k2);
  const double k4 = slope(e + step, f + step * k3);
  return {e + step, f + step * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0};
}

FrictionState moved(const FrictionSample& sample, FrictionState state, double strain) {
  const double way = strain - state.strain;
  const int steps = std::max(1, static_cast<int>(std::ceil(100.0 * std::abs(way) / sample.tau)));
  for (int i = 0; i < steps; ++i) state = stepped(sample, state, way / steps);
  state.strain = strain;
  return state;
}

}  // namespace tenter::twin
