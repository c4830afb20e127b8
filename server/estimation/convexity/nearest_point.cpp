// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/convexity/nearest_point.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <vector>

namespace tenter::estimation {
namespace {

/// Least squares over the columns that may move; the others are zero.
Eigen::VectorXd solve_free(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                           const std::vector<bool>& is_free) {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    if (is_free[static_cast<std::size_t>(j)]) columns.push_back(j);
  Eigen::MatrixXd part(a.rows(), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index k = 0; k < part.cols(); ++k)
    part.col(k) = a.col(columns[static_cast<std::size_t>(k)]);
  const Eigen::VectorXd solved = part.colPivHouseholderQr().solve(b);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(a.cols());
  for (Eigen::Index k = 0; k < part.cols(); ++k)
    u[columns[static_cast<std::size_t>(k)]] = solved[k];
  return u;
}

}  // namespace

Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index n = a.cols();
  Eigen::VectorXd u = Eigen::VectorXd::Zero(n);
  std::vector<bool> is_free(static_cast<std::size_t>(n), false);
  const double scale = std::max(a.cwiseAbs().maxCoeff() * b.cwiseAbs().maxCoeff(), 1e-300);
  for (Eigen::Index round = 0; round < 3 * n + 10; ++round) {
    const Eigen::VectorXd gain = a.transpose() * (b - a * u);
    Eigen::Index enter = -1;
    for (Eigen::Index j = 0; j < n; ++j)
      if (!is_free[static_cast<std::size_t>(j)] && gain[j] > 1e-14 * scale &&
          (enter < 0 || gain[j] > gain[enter]))
        enter = j;
    if (enter < 0) break;
    is_free[static_cast<std::size_t>(enter)] = true;
    Eigen::VectorXd wanted = solve_free(a, b, is_free);
    if (wanted[enter] <= 0.0) {  // its gain was rounding
      is_free[static_cast<std::size_t>(enter)] = false;
      break;
    }
    for (;;) {
      double step = 1.0;
      for (Eigen::Index j = 0; j < n; ++j)
        if (is_free[static_cast<std::size_t>(j)] && wanted[j] <= 0.0)
          step = std::min(step, u[j] / (u[j] - wanted[j]));
      u += step * (wanted - u);
      if (step >= 1.0) break;
      for (Eigen::Index j = 0; j < n; ++j)
        if (is_free[static_cast<std::size_t>(j)] && wanted[j] <= 0.0 && u[j] <= 1e-15 * u.norm()) {
          is_free[static_cast<std::size_t>(j)] = false;
          u[j] = 0.0;
        }
      wanted = solve_free(a, b, is_free);
    }
  }
  return u;
}

// min |y| with G y >= h: u >= 0 minimises |[G'; h'] u - e_last|; with r = [G'; h'] u - e_last the
// rows contradict each other where r = 0, and else y = -r_1..n / r_last.
std::optional<Eigen::VectorXd> nearest_point(const Eigen::VectorXd& x0,
                                             const Eigen::MatrixXd& metric,
                                             const Eigen::MatrixXd& rows,
                                             const Eigen::VectorXd& least) {
  if (rows.rows() == 0) return x0;
  const Eigen::Index n = x0.size();
  Eigen::LLT<Eigen::MatrixXd> factor;
  Eigen::MatrixXd g = rows;
  if (metric.size() > 0) {
    factor.compute(metric);
    if (factor.info() != Eigen::Success) return std::nullopt;
    g = factor.matrixL().solve(rows.transpose()).transpose();
  }
  Eigen::VectorXd h = least - rows * x0;
  for (Eigen::Index i = 0; i < g.rows(); ++i) {
    const double norm = g.row(i).norm();
    if (!(norm > 0.0)) continue;
    g.row(i) /= norm;
    h[i] /= norm;
  }
  const double far = std::max(h.maxCoeff(), 0.0);
  if (far == 0.0) return x0;
  h /= far;  // the distance becomes about one
  Eigen::MatrixXd dual(n + 1, g.rows());
  dual.topRows(n) = g.transpose();
  dual.row(n) = h.transpose();
  Eigen::VectorXd last = Eigen::VectorXd::Unit(n + 1, n);
  const Eigen::VectorXd r = dual * non_negative_least_squares(dual, last) - last;
  if (!(r.norm() > 1e-10)) return std::nullopt;
  Eigen::VectorXd y = r.head(n) * (-far / r[n]);
  if (metric.size() > 0) y = factor.matrixU().solve(y);
  return x0 + y;
}

}  // namespace tenter::estimation
