// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/stretch/length_errors.h"

#include <cmath>
#include <utility>

namespace tenter::estimation {

LengthErrors::LengthErrors(StrainPoint point, WeightTable table)
    : point_(std::move(point)), table_(std::move(table)) {
  int block = 0;
  for (std::size_t i = 0; i < table_.readings.size(); ++i) {
    if (i > 0 && table_.readings[i].run != table_.readings[i - 1].run) ++block;
    rows_.push_back({0, 0, static_cast<int>(i), block});
  }
}

mechanics::PathStatus LengthErrors::evaluate(const Eigen::VectorXd& parameters,
                                             Eigen::VectorXd& residuals, RowMatrix* jacobian) {
  const auto count = static_cast<Eigen::Index>(rows_.size());
  residuals.resize(count);
  if (jacobian != nullptr) jacobian->resize(count, parameter_count());
  point_.begin(walk_);
  int snapped = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool run_starts = k > 0 && rows_[k].block != rows_[k - 1].block;
    if (run_starts && table_.between == BetweenRuns::flattened) {
      snapped += walk_.snapped;
      point_.begin(walk_);
    }
    const auto status = point_.to_load(table_.load(k), parameters, walk_);
    if (status != mechanics::PathStatus::ok) return status;
    const double stretch = std::sqrt(1.0 + 2.0 * walk_.strain);
    residuals[i] =
        (table_.rest_length_m * stretch - table_.readings[k].length_m) / table_.length_noise_m;
    if (jacobian != nullptr)
      jacobian->row(i) = (table_.rest_length_m / (stretch * table_.length_noise_m)) *
                         walk_.strain_by_p.transpose();
  }
  walk_.snapped += snapped;
  return residuals.allFinite() ? mechanics::PathStatus::ok : mechanics::PathStatus::not_finite;
}

}  // namespace tenter::estimation
