// SPDX-License-Identifier: GPL-3.0-or-later
// What a fit to cantilevers alone makes small: the torque that the model has at the curvature that
// was seen, against that of the weight (Clapp et al.: a moment-curvature relation from one shape).
//
//   r = L^-1 ( sigma(eps_i) - T_i ),   L L' = covariance of (T_i - sigma' eps_i), one contour's
//   noise
//
// A strip that was never rolled goes one way from flat, so that every sample is a place on one
// curve and no rest has to be found. One row per sample, blocks are strips. The covariance is that
// at the parameters given last to set_reference(); Jacobian exact with it held. One thread per
// object.
#pragma once

#include <memory>
#include <vector>

#include "server/estimation/friction_tests/bending/torque_samples.h"
#include "server/estimation/friction_tests/strain_point.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

class MomentErrors final : public ResidualFunction {
 public:
  MomentErrors(StrainPoint point, std::shared_ptr<const std::vector<ProfileSamples>> profiles,
               const Eigen::VectorXd& parameters);

  int parameter_count() const override { return point_.parameter_count(); }
  const std::vector<Row>& rows() const override { return rows_; }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;
  void set_reference(const Eigen::VectorXd& parameters);

 private:
  StrainPoint point_;
  std::shared_ptr<const std::vector<ProfileSamples>> profiles_;
  std::vector<Row> rows_;
  std::vector<Eigen::MatrixXd> factors_;  ///< of each profile's covariance, lower
  StrainPoint::Walk walk_;
};

}  // namespace tenter::estimation
