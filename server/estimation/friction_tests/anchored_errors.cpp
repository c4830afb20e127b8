// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/anchored_errors.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tenter::estimation {

AnchoredErrors::AnchoredErrors(std::vector<AnchoredReading> readings, double sigma_load)
    : readings_(std::move(readings)), sigma_(sigma_load) {
  rows_.reserve(readings_.size());
  for (std::size_t i = 0; i < readings_.size(); ++i)
    rows_.push_back({0, 0, static_cast<int>(i), readings_[i].block});
}

mechanics::PathStatus AnchoredErrors::evaluate(const Eigen::VectorXd& p, Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) {
  const auto count = static_cast<Eigen::Index>(readings_.size());
  residuals.resize(count);
  if (jacobian != nullptr) jacobian->setZero(count, kFrictionParameters);
  for (Eigen::Index i = 0; i < count; ++i) {
    const AnchoredReading& reading = readings_[static_cast<std::size_t>(i)];
    const double e = reading.strain;
    const double size = std::abs(e);
    const double anchor_size = std::abs(reading.anchor);
    const double s = reading.sign;
    const double way = std::max(0.0, s * (e - reading.anchor));  // noise may put it before
    const double decay = std::exp(-way / p[kTau]);
    const double anchor_stress = 2.0 * s * (p[kA] + p[kB] * anchor_size);
    const double stress =
        (p[kK1] + p[kK2] * size) * e + s * (p[kA] + p[kB] * size) - anchor_stress * decay;
    const double scale = -reading.weight / sigma_;
    residuals[i] = reading.load / sigma_ + scale * stress;
    if (jacobian == nullptr) continue;
    auto row = jacobian->row(i);
    row[kK1] = scale * e;
    row[kK2] = scale * size * e;
    row[kA] = scale * s * (1.0 - 2.0 * decay);
    row[kB] = scale * s * (size - 2.0 * anchor_size * decay);
    row[kTau] = -scale * anchor_stress * decay * way / (p[kTau] * p[kTau]);
  }
  return residuals.allFinite() ? mechanics::PathStatus::ok : mechanics::PathStatus::not_finite;
}

}  // namespace tenter::estimation
