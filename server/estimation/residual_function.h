// SPDX-License-Identifier: GPL-3.0-or-later
// What a fit makes small: residuals of a model against measurements, and their Jacobian.
//
//   r = (predicted - measured) / sigma        one row per measured value
//
// Parameters are flat: those of the model's terms, then those of its sensor corrections.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/mechanics/material_point.h"

namespace tenter::estimation {

using mechanics::RowMatrix;

/// One residual's place. Rows of a block and channel follow each other.
struct Row {
  int curve = 0;  ///< or sequence
  int channel = 0;
  int frame = 0;  ///< kept frame within the curves
  int block = 0;  ///< global block index over all curves
};

enum class Accuracy {
  exact,
  stepping  ///< good enough to choose the next step by: a fit is on its way
};

class ResidualFunction {
 public:
  virtual ~ResidualFunction() = default;
  virtual int parameter_count() const = 0;
  virtual const std::vector<Row>& rows() const = 0;
  int row_count() const { return static_cast<int>(rows().size()); }

  /// Whitened residuals of all rows and, where not null, their Jacobian (rows x parameters).
  [[nodiscard]] virtual mechanics::PathStatus evaluate(const Eigen::VectorXd& parameters,
                                                       Eigen::VectorXd& residuals,
                                                       RowMatrix* jacobian) = 0;

  /// Of the evaluations that follow; exact until told otherwise.
  virtual void set_accuracy(Accuracy) {}
  /// What each row's square counts in the cost, one per row; empty: one.
  virtual Eigen::VectorXd weights() const { return {}; }
};

}  // namespace tenter::estimation
