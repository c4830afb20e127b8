// SPDX-License-Identifier: GPL-3.0-or-later
// What a fit to hanging weights makes small: the lengths that the model hangs at, against those
// that were read.
//
//   r = (L0 sqrt(1 + 2 eps_i) - L_i) / sigma_L,   eps_i: where the model comes to rest under the
//   i-th weight, coming from where it was under the one before
//
// Weights are known far better than lengths, so the noise sits in the lengths and nowhere else:
// no anchor is taken for exact, friction need not be saturated anywhere, and intervals are right.
// The first run begins unstrained. One row per reading, blocks are runs. Exact Jacobian; about 10
// evaluations of the laws per reading. One thread per object.
#pragma once

#include <vector>

#include "server/estimation/friction_tests/strain_point.h"
#include "server/estimation/friction_tests/stretch/weight_table.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

class LengthErrors final : public ResidualFunction {
 public:
  /// `table` was checked and its length_noise_m is above zero.
  LengthErrors(StrainPoint point, WeightTable table);

  int parameter_count() const override { return point_.parameter_count(); }
  const std::vector<Row>& rows() const override { return rows_; }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;
  const WeightTable& table() const { return table_; }
  /// Steps of the last evaluation in which the stress fell on the way.
  int snapped() const { return walk_.snapped; }

 private:
  StrainPoint point_;
  WeightTable table_;
  std::vector<Row> rows_;
  StrainPoint::Walk walk_;
};

}  // namespace tenter::estimation
