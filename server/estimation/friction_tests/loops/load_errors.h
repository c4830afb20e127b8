// SPDX-License-Identifier: GPL-3.0-or-later
// What a fit to loops makes small: the load that the model has at the strains that were imposed,
// against the load that was read.
//
//   r = (w sigma(eps_i, history) - load_i) / sigma_load,   w = sqrt(1 + 2 eps_i)
//
// along the whole way of the strain: no anchor is taken for exact or saturated. The strain is known
// far better than the load, so the noise sits in the loads. One row per reading, blocks are
// branches. Exact Jacobian; one evaluation of the laws a reading. One thread per object.
#pragma once

#include <vector>

#include "server/estimation/friction_tests/loops/loop_table.h"
#include "server/estimation/friction_tests/strain_point.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

class LoadErrors final : public ResidualFunction {
 public:
  /// `table` was checked and its load_noise is above zero.
  LoadErrors(StrainPoint point, LoopTable table);

  int parameter_count() const override { return point_.parameter_count(); }
  const std::vector<Row>& rows() const override { return rows_; }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;

 private:
  StrainPoint point_;
  LoopTable table_;
  std::vector<Row> rows_;
  std::vector<bool> begins_;
  StrainPoint::Walk walk_;
};

}  // namespace tenter::estimation
