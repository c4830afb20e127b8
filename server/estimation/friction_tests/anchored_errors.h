// SPDX-License-Identifier: GPL-3.0-or-later
// The errors of the papers: what is missing to equilibrium at a measured strain, with friction that
// is saturated at the anchor before it.
//
//   f = load - w ((k1 + k2 |eps|) eps + sigma)                          (thesis 5.5, 5.7)
//   sigma = s (a + b |eps|) - 2 s (a + b |eps_anchor|) exp(-s (eps - eps_anchor) / tau)    (5.4)
//
// 5.4 takes the measured anchor for the true one, friction there for saturated, and leaves b tau
// out. So this is where a fit starts from (anchored_start.h) and what it is compared with; what
// is reported comes from the whole path (stretch/length_errors.h,
// bending/contour/contour_errors.h).
//
// One row per reading that has an anchor, r = f / sigma_load, parameters as in friction_model.h,
// exact Jacobian. One thread per object.
#pragma once

#include <vector>

#include "server/estimation/friction_tests/friction_model.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

struct AnchoredReading {
  double load = 0.0;    ///< N/m; bending: N
  double strain = 0.0;  ///< 1; bending: 1/m
  double weight = 1.0;  ///< d eps / d lambda; bending: 1
  double anchor = 0.0;  ///< strain there
  double sign = 1.0;    ///< of the strain's change since the anchor
  int block = 0;
};

class AnchoredErrors final : public ResidualFunction {
 public:
  AnchoredErrors(std::vector<AnchoredReading> readings, double sigma_load);

  int parameter_count() const override { return kFrictionParameters; }
  const std::vector<Row>& rows() const override { return rows_; }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;
  const std::vector<AnchoredReading>& readings() const { return readings_; }

 private:
  std::vector<AnchoredReading> readings_;
  double sigma_;
  std::vector<Row> rows_;
};

}  // namespace tenter::estimation
