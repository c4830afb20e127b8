// SPDX-License-Identifier: GPL-3.0-or-later
// Splines over many strains: the basis functions are summed up once for the batch, then each strain
// costs its interval and three short polynomials.
#include <algorithm>

#include "server/mechanics/laws/spline.h"

namespace tenter::mechanics {

// With v(t) = sum_k v_k t^k on [start, start + w], eps = start + w t and M_n = integral of v eps^n:
//   M_0(t) = M_0(0) + w sum_k v_k t^(k+1)/(k+1)
//   M_1(t) = M_1(0) + w sum_k v_k (start t^(k+1)/(k+1) + w t^(k+2)/(k+2))
// A stiffness has the energy M_1; the convex form has the stress M_0 and the energy eps M_0 - M_1.
void SplineLaw::build_curves(const double* parameters, Curve* curves) const {
  double zero[2] = {0.0, 0.0};
  for (int power = 0; power < 2; ++power)
    for (int j = 0; j < points_; ++j)
      zero[power] += parameters[j] * moment_at_zero_[power][static_cast<std::size_t>(j)];

  double after[2] = {0.0, 0.0};  // moments at the end of the last control interval
  for (int i = -1; i <= intervals_; ++i) {
    const bool inside = i >= 0 && i < intervals_;
    Curve& curve = curves[i + 1];
    const double from = start(i);
    const double wide = width(i);
    double v[4] = {0.0, 0.0, 0.0, 0.0};
    double moment[2] = {0.0, 0.0};
    for (int j = 0; j < points_; ++j) {
      const double p = parameters[j];
      if (inside) {
        for (int k = 0; k < 4; ++k) v[k] += p * piece(j, i).c[k];
        for (int power = 0; power < 2; ++power) moment[power] += p * piece(j, i).moment[power];
      } else {
        v[0] += p * end_value(j, i == intervals_);
      }
    }
    double m0[6] = {};
    double m1[6] = {};
    for (int k = 0; k < 4; ++k) {
      const double c = v[k] * wide;
      m0[k + 1] = c / (k + 1);
      m1[k + 1] += c * from / (k + 1);
      m1[k + 2] += c * wide / (k + 2);
    }
    if (i < 0) {  // ends where the moments begin
      moment[0] = -m0[1];
      moment[1] = -(m1[1] + m1[2]);
    } else if (i == intervals_) {
      moment[0] = after[0];
      moment[1] = after[1];
    }
    m0[0] = moment[0];
    m1[0] = moment[1];
    after[0] = after[1] = 0.0;
    for (int k = 0; k < 6; ++k) {
      after[0] += m0[k];
      after[1] += m1[k];
    }
    m0[0] -= zero[0];
    m1[0] -= zero[1];
    for (int k = 0; k < 4; ++k) curve.value[k] = v[k];
    for (int k = 0; k < 5; ++k) curve.stress[k] = m0[k];
    for (int k = 0; k < 6; ++k) curve.energy[k] = m1[k];
    if (form_ != Form::convex) continue;
    for (int k = 0; k < 6; ++k)
      curve.energy[k] = from * m0[k] + (k > 0 ? wide * m0[k - 1] : 0.0) - m1[k];
  }
}

void SplineLaw::evaluate_batch(const double* parameters, const LawBatch& batch) const {
  Curve curves[kMaxLawParameters + 2];
  build_curves(parameters, curves);
  double per_width[kMaxLawParameters + 2];
  for (int i = -1; i <= intervals_; ++i) per_width[i + 1] = 1.0 / width(i);
  const double last = intervals_;
  if (batch.energy != nullptr) std::fill_n(batch.energy, batch.count, 0.0);
  const bool wants_tangent = batch.tangent[0][0] != nullptr;
  for (int i = 0; i < strain_count(); ++i) {
    const double* __restrict strain = batch.strain[i];
    double* __restrict stress = batch.stress[i];
    double* __restrict tangent = wants_tangent ? batch.tangent[i][i] : nullptr;
    for (int e = 0; e < batch.count; ++e) {
      const double eps = strain[e];
      const double x = coordinate(eps);  // as in evaluate(), so that an end is the same end
      // in this order an x that is no number has a place, and gives no number
      const double within = std::max(0.0, std::min(last, x));
      int interval = std::min(static_cast<int>(within), intervals_ - 1);
      if (x < 0.0) interval = -1;
      if (x > last) interval = intervals_;
      const double t = x - interval;
      const Curve& curve = curves[interval + 1];
      const double* v = curve.value;
      const double value = v[0] + t * (v[1] + t * (v[2] + t * v[3]));
      if (form_ == Form::convex) {
        const double* s = curve.stress;
        stress[e] = s[0] + t * (s[1] + t * (s[2] + t * (s[3] + t * s[4])));
        if (wants_tangent) tangent[e] = value;
      } else {
        stress[e] = value * eps;
        const double slope = (v[1] + t * (2.0 * v[2] + 3.0 * t * v[3])) * per_width[interval + 1];
        if (wants_tangent) tangent[e] = value + slope * eps;
      }
      if (batch.energy == nullptr) continue;
      const double* w = curve.energy;
      batch.energy[e] += w[0] + t * (w[1] + t * (w[2] + t * (w[3] + t * (w[4] + t * w[5]))));
    }
    if (!wants_tangent) continue;
    for (int j = i + 1; j < strain_count(); ++j) std::fill_n(batch.tangent[i][j], batch.count, 0.0);
  }
}

void SplineLaw::stress_by_parameter_batch(const double*, int parameter,
                                          const LawBatch& batch) const {
  double alone[kMaxLawParameters] = {};
  alone[parameter] = 1.0;
  LawBatch stress = batch;
  stress.energy = nullptr;
  stress.tangent[0][0] = nullptr;
  evaluate_batch(alone, stress);
}

}  // namespace tenter::mechanics
