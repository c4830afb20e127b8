// SPDX-License-Identifier: GPL-3.0-or-later
// From which a fit to spirals and cantilevers starts: the curvature at which the model holds the
// torque of the weight, against the curvature that was seen.
//
//   r_i = ( mean_q eps(T_iq) - eps_i ) / sigma_i
//
// eps(T): where the model comes to rest under T after going from flat to 3/radius and back
// (strain_point.h): friction need not be saturated on the cylinder, and steps of the stress on the
// way are passed in a snap. Cantilevers go from flat to T. The errors of T and eps come from the
// same noisy contour; together they make the covariance of a profile's rows, with which they are
// whitened, at the parameters that were given last to set_reference(). What an error of T does is
// taken over one standard deviation to either side, and what of that is not linear is added as a
// scatter of its own: beside a snap both are large, and the sample hardly counts.
//
// Strain is no smooth function of the torque where a strip rests at a snap, and a spline rounds off
// what bends sharply: off by some of its errors, this is near enough to begin with, and needs no
// more than a strain and a torque. What is reported comes from the strips' shapes
// (contour/contour_errors.h).
//
// One row per kept sample, blocks are strips of one radius. Exact Jacobian (the whitening held).
// Cost: about 4 evaluations of the laws per torque. One thread per object.
#pragma once

#include <memory>
#include <vector>

#include "server/estimation/friction_tests/bending/torque_samples.h"
#include "server/estimation/friction_tests/strain_point.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

class TorqueErrors final : public ResidualFunction {
 public:
  TorqueErrors(StrainPoint point, std::shared_ptr<const std::vector<ProfileSamples>> profiles);

  int parameter_count() const override { return point_.parameter_count(); }
  const std::vector<Row>& rows() const override { return rows_; }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;
  [[nodiscard]] mechanics::PathStatus set_reference(const Eigen::VectorXd& parameters);

 private:
  /// Fills strains_ and strains_by_p_ for the torques_.
  [[nodiscard]] mechanics::PathStatus predict(double anchor, const Eigen::VectorXd& parameters);
  [[nodiscard]] mechanics::PathStatus walk_side(double anchor, const Eigen::VectorXd& parameters,
                                                bool up);
  void read_torques(std::size_t profile);

  StrainPoint point_;
  std::shared_ptr<const std::vector<ProfileSamples>> profiles_;
  std::vector<Row> rows_;
  std::vector<Eigen::MatrixXd> factors_;  ///< of each profile's covariance, lower
  StrainPoint::Walk walk_;
  std::vector<int> order_;
  Eigen::VectorXd torques_, strains_;  ///< of one profile
  RowMatrix strains_by_p_, block_;
};

}  // namespace tenter::estimation
