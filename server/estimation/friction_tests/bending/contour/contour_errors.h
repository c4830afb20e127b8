// SPDX-License-Identifier: GPL-3.0-or-later
// What a fit to spirals and cantilevers makes small: the distances of the points that were seen
// from the strip of the model, as it hangs (resting_shape.h).
//
//   r_j = n_j . (P_j - X(s_j)) / sigma      X(s_j): where the strip is next to the point
//
// All that is uncertain is where the points lie. Torque and curvature, which both follow from them,
// are the model's own: so it does not matter that strain is no smooth function of the torque where
// a strip snaps, nor that a smooth curve rounds off what bends sharply.
//
// The ends of a strip are seen, and count along it as well. Pieces left out (torque_samples.h) keep
// their measured bend; of the law they say nothing, but their points tell where the weight hangs
// that bends what is above them. What the data do not say beforehand, the placement of each strip
// with the turns of such pieces, as many as the smooth curve has intervals there, is taken out:
// rows are those of the best placement near set_reference()'s.
//
// One row per point, blocks are strips of one radius. Exact Jacobian (with the reference held).
// sigma is each profile's own scatter about its smooth curve. One thread per object.
#pragma once

#include <memory>
#include <vector>

#include "server/estimation/friction_tests/bending/contour/resting_shape.h"
#include "server/estimation/friction_tests/bending/torque_samples.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

class ContourErrors final : public ResidualFunction {
 public:
  ContourErrors(StrainPoint point, std::shared_ptr<const std::vector<ProfileSamples>> profiles);

  int parameter_count() const override { return point_.parameter_count(); }
  const std::vector<Row>& rows() const override { return rows_; }
  [[nodiscard]] mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                               Eigen::VectorXd& residuals,
                                               RowMatrix* jacobian) override;
  /// Finds each strip's placement, from that at the last reference; before any, it is as read, and
  /// nothing is taken out.
  [[nodiscard]] mechanics::PathStatus set_reference(const Eigen::VectorXd& parameters);

  /// Mean strain of the model's strip over each sample of the profiles, at the last evaluation.
  const std::vector<double>& predicted() const { return predicted_; }
  /// Strips that are past a snap somewhere.
  int snapped() const { return snapped_; }

 private:
  struct Strip {
    RestingShape shape;
    std::vector<ContourPoint> points;  ///< none where no piece is kept
    struct Stand {
      Eigen::VectorXd arcs;  ///< of the points
      Eigen::VectorXd placement;
      Eigen::VectorXd directions;  ///< at the cells' borders
    };
    Stand read;              ///< of the smooth curve
    Stand at;                ///< of the model's strip at the reference
    Eigen::MatrixXd placed;  ///< orthonormal: rows that the placement can follow
    double misfit = 0.0;     ///< sum of squares at the reference
    int first_row = 0;
    int row_count() const;
  };
  /// Rows of one strip, not yet without what the placement follows. Columns of `by`: parameters,
  /// placement.
  [[nodiscard]] bool look(Strip& strip, const ProfileSamples& profile,
                          const Eigen::VectorXd& parameters, const Eigen::VectorXd& placement,
                          Eigen::VectorXd& arcs, Eigen::VectorXd& distances, RowMatrix* by);
  [[nodiscard]] bool find_placement(Strip& strip, const ProfileSamples& profile,
                                    const Eigen::VectorXd& parameters);

  StrainPoint point_;
  std::shared_ptr<const std::vector<ProfileSamples>> profiles_;
  std::vector<Strip> strips_;
  std::vector<Row> rows_;
  double reach_ = 0.0;
  std::vector<double> predicted_;
  int snapped_ = 0;
};

}  // namespace tenter::estimation
