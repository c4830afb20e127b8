// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/twin/fabrics/stiffness_curve.h"

#include <algorithm>
#include <cmath>

namespace tenter::twin {

namespace {

int interval_of(const StiffnessCurve& curve, double strain) {
  const int intervals = static_cast<int>(curve.k.size()) - 1;
  const double place = (strain - curve.lo) / (curve.hi - curve.lo) * intervals;
  return std::clamp(static_cast<int>(std::floor(place)), 0, intervals - 1);
}

}  // namespace

StiffnessCurve::Piece StiffnessCurve::piece(int interval) const {
  const int last = static_cast<int>(k.size()) - 1;
  const auto value = [&](int i) { return k[static_cast<std::size_t>(i)]; };
  const auto slope = [&](int i) {
    const int below = std::max(i - 1, 0);
    const int above = std::min(i + 1, last);
    return (value(above) - value(below)) / (above - below);
  };
  const double k0 = value(interval), k1 = value(interval + 1);
  const double m0 = slope(interval), m1 = slope(interval + 1);
  Piece result;
  result.width = (hi - lo) / last;
  result.start = lo + interval * result.width;
  result.c[0] = k0;
  result.c[1] = m0;
  result.c[2] = 3.0 * (k1 - k0) - 2.0 * m0 - m1;
  result.c[3] = 2.0 * (k0 - k1) + m0 + m1;
  return result;
}

double StiffnessCurve::stiffness(double strain) const {
  if (k.size() == 1 || strain <= lo) return k.front();
  if (strain >= hi) return k.back();
  const Piece p = piece(interval_of(*this, strain));
  const double t = (strain - p.start) / p.width;
  return p.c[0] + t * (p.c[1] + t * (p.c[2] + t * p.c[3]));
}

// Within a piece, with s = start + width t:  integral of k s ds = width sum_i c_i (start
// t^(i+1)/(i+1)
// + width t^(i+2)/(i+2)).
double StiffnessCurve::energy_from_lo(double strain) const {
  const auto outside = [](double stiffness, double from, double to) {
    return 0.5 * stiffness * (to * to - from * from);
  };
  if (strain <= lo) return outside(k.front(), lo, strain);
  const double inside = std::min(strain, hi);
  const int last = interval_of(*this, inside);
  double sum = 0.0;
  for (int i = 0; i <= last; ++i) {
    const Piece p = piece(i);
    const double t = i < last ? 1.0 : (inside - p.start) / p.width;
    double power = t;
    for (int d = 0; d < 4; ++d) {
      sum += p.width * p.c[d] * power * (p.start / (d + 1) + p.width * t / (d + 2));
      power *= t;
    }
  }
  return strain > hi ? sum + outside(k.back(), hi, strain) : sum;
}

CurveValue StiffnessCurve::at(double strain) const {
  if (k.size() == 1) return {0.5 * k.front() * strain * strain, k.front() * strain, k.front()};
  const double stiff = stiffness(strain);
  double slope = 0.0;
  if (strain > lo && strain < hi) {
    const Piece p = piece(interval_of(*this, strain));
    const double t = (strain - p.start) / p.width;
    slope = (p.c[1] + t * (2.0 * p.c[2] + 3.0 * t * p.c[3])) / p.width;
  }
  return {energy_from_lo(strain) - energy_from_lo(0.0), stiff * strain, stiff + slope * strain};
}

double StiffnessCurve::largest() const {
  return *std::max_element(k.begin(), k.end());
}

}  // namespace tenter::twin
