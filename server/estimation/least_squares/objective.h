// SPDX-License-Identifier: GPL-3.0-or-later
// The cost of a fit as a function of its free parameters, in few rows.
//
//   cost = sum over rows  weight rho(r^2)          rho(s) = s, or a robust loss of it
//
// A minimiser needs of all rows only their sum of squares, J'J and J'r, so they are compressed:
// with f = r sqrt(weight rho(r^2)/r^2), whose squares sum to the cost, and [J f] = Q R, the
// minimiser sees the rows of R (as many as there are free parameters, and one), by Householder's QR
// of one batch of rows after the other. Parameters are divided by their scale.
//
//   Objective objective(evaluator, all, free, scale, weights, loss);
//   bool ok = objective.evaluate(x, residuals, &jacobian);     // |residuals|^2 = cost
//
// One thread; deterministic.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/fit.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

/// rho and its first two derivatives at s = r^2, with the scale `a` in sigmas: Huber's
/// s below a^2, 2 a sqrt(s) - a^2 above; Cauchy's a^2 log(1 + s/a^2).
struct LossValue {
  double rho = 0.0;
  double by_s = 0.0;
  double by_ss = 0.0;
};
LossValue loss_at(const RobustLoss& loss, double s);

class Objective {
 public:
  /// `all` holds the values of what is fixed and is written to. `weights`: one a row.
  Objective(ResidualFunction& evaluator, Eigen::VectorXd& all, std::vector<int> free,
            Eigen::VectorXd scale, const Eigen::VectorXd& weights, const RobustLoss& loss);
  /// The same with only these of its parameters free; the others stay where `all` has them.
  Objective with_free(const std::vector<int>& kept) const;

  int parameter_count() const { return static_cast<int>(free_.size()); }
  int row_count() const { return parameter_count() + 1; }
  /// False where the model has no equilibrium. x, residuals and jacobian (row-major, null: not
  /// wanted) are of the scaled free parameters.
  [[nodiscard]] bool evaluate(const double* x, double* residuals, double* jacobian);

 private:
  void compress();

  ResidualFunction& evaluator_;
  Eigen::VectorXd& all_;
  std::vector<int> free_;
  Eigen::VectorXd scale_;
  const Eigen::VectorXd& weights_;
  const RobustLoss& loss_;
  Eigen::VectorXd r_;
  RowMatrix j_;
  Eigen::MatrixXd batch_;  ///< R so far above the rows that come next
  Eigen::VectorXd coefficients_, scratch_;
};

}  // namespace tenter::estimation
