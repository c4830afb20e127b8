// SPDX-License-Identifier: GPL-3.0-or-later
// A linear least-squares problem of few unknowns and any number of rows, with bounds:
//
//   x = argmin |A x - b|^2      lower <= x <= upper
//
// Rows are compressed as they come (an orthogonal factor of [A b] is kept, nothing is squared), and
// the bounds are met by an active set (Stark and Parker's BVLS): exact after finitely many steps.
//
//   BoundedLeastSquares problem(count);
//   problem.add(a, b);                                    // as often as wanted
//   BoundedSolution s = problem.solve(lower, upper);      // infinite: no bound
//
// Where rows determine no direction, the shortest change of the start decides. Pure; cost O(rows
// count^2) for adding, O(count^4) at worst for solving.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace tenter::estimation {

/// A bound that holds nothing; with a minus sign below.
inline constexpr double kNoBound = std::numeric_limits<double>::infinity();

struct BoundedSolution {
  Eigen::VectorXd x;
  double residual = 0.0;  ///< |A x - b|
  std::vector<bool> is_at_bound;
  int rank = 0;  ///< of A, without bounds
};

class BoundedLeastSquares {
 public:
  explicit BoundedLeastSquares(int unknowns);

  void add(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
  /// Starts at zero, or where `start` says, put within the bounds.
  BoundedSolution solve(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                        const Eigen::VectorXd* start = nullptr) const;

 private:
  int unknowns_;
  Eigen::MatrixXd triangle_;  ///< (n + 1) x (n + 1), upper: of [A b]
};

}  // namespace tenter::estimation
