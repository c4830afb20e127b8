// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/laws/hermite_energy.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {
namespace {

double value(const double* c, double t) {
  return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
}
double slope(const double* c, double t) {
  return c[1] + t * (2.0 * c[2] + 3.0 * t * c[3]);
}
double curvature(const double* c, double t) {
  return 2.0 * c[2] + 6.0 * t * c[3];
}

}  // namespace

// Between points i and i + 1: h00 w_i + h10 m_i + h01 w_(i+1) + h11 m_(i+1), m_i = (w_(i+1) -
// w_(i-1))/2, at the ends of the parabola through three points: one-sided differences would bend
// every energy down there, so that none but a straight one could be convex. A continuation is the
// Taylor polynomial of its end, of second degree; before the first point it is that of t + 1 =
// distance from one interval earlier.
HermiteEnergyLaw::HermiteEnergyLaw(int points, double range_lo, double range_hi)
    : Law(1, points, 0),
      intervals_(points - 1),
      lo_(range_lo),
      width_((range_hi - range_lo) / intervals_) {
  for (int j = 0; j < points; ++j) {
    const auto weight = [j](int point) { return j == point ? 1.0 : 0.0; };
    const auto slope_at = [&](int point) {
      if (points == 2) return weight(1) - weight(0);
      if (point > 0 && point + 1 < points) return 0.5 * (weight(point + 1) - weight(point - 1));
      const int end = point == 0 ? 0 : points - 1;
      const int inward = point == 0 ? 1 : -1;
      return 0.5 * inward *
             (-3.0 * weight(end) + 4.0 * weight(end + inward) - weight(end + 2 * inward));
    };
    std::vector<Piece> inside;
    for (int i = 0; i < intervals_; ++i) {
      const double w0 = weight(i), w1 = weight(i + 1);
      const double m0 = slope_at(i), m1 = slope_at(i + 1);
      inside.push_back(
          {{w0, m0, -3.0 * w0 - 2.0 * m0 + 3.0 * w1 - m1, 2.0 * w0 + m0 - 2.0 * w1 + m1}});
    }
    const double* first = inside.front().c;
    const double* last = inside.back().c;
    // around t = 1 of the interval before the first
    pieces_.push_back({{first[0] - first[1] + first[2], first[1] - 2.0 * first[2], first[2], 0.0}});
    pieces_.insert(pieces_.end(), inside.begin(), inside.end());
    pieces_.push_back({{value(last, 1.0), slope(last, 1.0), 0.5 * curvature(last, 1.0), 0.0}});
  }
  const Place rest = place_of(0.0);
  for (int j = 0; j < points; ++j) at_rest_.push_back(value(piece(j, rest.interval).c, rest.t));
}

HermiteEnergyLaw::Place HermiteEnergyLaw::place_of(double strain) const {
  const double x = (strain - lo_) / width_;
  // in this order an x that is no number has a place, and gives no number
  int interval = static_cast<int>(std::max(0.0, std::min(intervals_ - 0.5, x)));
  if (x < 0.0) interval = -1;
  if (x > intervals_) interval = intervals_;
  return {interval, x - interval};
}

void HermiteEnergyLaw::evaluate(const LawInput& in, LawOutput& out) const {
  const Place place = place_of(in.strain[0]);
  for (int j = 0; j < parameter_count(); ++j) {
    const double* c = piece(j, place.interval).c;
    const double w = in.parameters[j];
    const double by_w = slope(c, place.t) / width_;
    out.energy += w * (value(c, place.t) - at_rest_[static_cast<std::size_t>(j)]);
    out.stress[0] += w * by_w;
    out.tangent[0][0] += w * curvature(c, place.t) / (width_ * width_);
    out.stress_by_parameter[0][j] = by_w;
  }
}

void HermiteEnergyLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  Piece curves[kMaxLawParameters + 1] = {};
  double rest = 0.0;
  for (int j = 0; j < parameter_count(); ++j) {
    rest += parameters[j] * at_rest_[static_cast<std::size_t>(j)];
    for (int i = -1; i <= intervals_; ++i)
      for (int k = 0; k < 4; ++k) curves[i + 1].c[k] += parameters[j] * piece(j, i).c[k];
  }
  for (int e = 0; e < batch.count; ++e) {
    const Place place = place_of(batch.strain[0][e]);
    const double* c = curves[place.interval + 1].c;
    batch.stress[0][e] = slope(c, place.t) / width_;
    if (batch.energy != nullptr) batch.energy[e] = value(c, place.t) - rest;
    if (batch.tangent[0][0] != nullptr)
      batch.tangent[0][0][e] = curvature(c, place.t) / (width_ * width_);
  }
}

}  // namespace tenter::mechanics
