// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/loops/load_errors.h"

#include <utility>

namespace tenter::estimation {

LoadErrors::LoadErrors(StrainPoint point, LoopTable table)
    : point_(std::move(point)), table_(std::move(table)) {
  begins_.assign(table_.readings.size(), false);
  for (const int first : table_.beginnings) begins_[static_cast<std::size_t>(first)] = true;
  int block = 0;
  for (std::size_t i = 0; i < table_.readings.size(); ++i) {
    const bool is_new =
        i > 0 && (begins_[i] || table_.readings[i].branch != table_.readings[i - 1].branch);
    if (is_new) ++block;
    rows_.push_back({0, 0, static_cast<int>(i), block});
  }
}

mechanics::PathStatus LoadErrors::evaluate(const Eigen::VectorXd& parameters,
                                           Eigen::VectorXd& residuals, RowMatrix* jacobian) {
  const auto count = static_cast<Eigen::Index>(rows_.size());
  residuals.resize(count);
  if (jacobian != nullptr) jacobian->resize(count, parameter_count());
  point_.begin(walk_);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (k > 0 && begins_[k]) point_.begin(walk_);
    point_.to_strain(table_.readings[k].strain, parameters, walk_);
    residuals[i] = (walk_.load - table_.readings[k].load) / table_.load_noise;
    if (jacobian != nullptr) jacobian->row(i) = walk_.load_by_p.transpose() / table_.load_noise;
  }
  return residuals.allFinite() ? mechanics::PathStatus::ok : mechanics::PathStatus::not_finite;
}

}  // namespace tenter::estimation
