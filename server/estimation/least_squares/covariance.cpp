// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/covariance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "server/estimation/least_squares/objective.h"

namespace tenter::estimation {
namespace {

bool is_at_bound(const model::Parameter& p, double value) {
  const double slack = 1e-7 * std::max(1.0, std::abs(value));
  if (p.lower && value - *p.lower <= slack) return true;
  return p.upper && *p.upper - value <= slack;
}

/// What a row is worth: `bread` w psi', `filling` v w^2.
struct RowWorth {
  Eigen::VectorXd bread, filling;
};

/// All rows alike: the inflation of one sigma is one number.
RowWorth equal_worth(const Eigen::VectorXd& weights, double moving, const FitResult& result) {
  // one sigma of a row stands for rows/effective_rows of them, and more where the model's form is
  // wrong
  const double used = weights.sum();
  const double inflation = std::max(1.0, result.chi2 / std::max(1.0, used)) * used /
                           std::max(1.0, result.effective_rows - moving);
  return {weights, std::max(1.0, inflation) * weights};
}

RowWorth worth_by_curve(const Eigen::VectorXd& weights, const RobustLoss& loss,
                        const std::vector<Row>& rows, double moving, const FitResult& result) {
  struct Sums {
    double rows = 0.0, psi2 = 0.0, slope = 0.0, effective = 0.0;
  };
  std::vector<Sums> curves;
  double used = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const auto c = static_cast<std::size_t>(rows[k].curve);
    if (curves.size() <= c) curves.resize(c + 1);
    if (!(weights[row] > 0.0)) continue;
    const double s = result.residuals[row] * result.residuals[row];
    const LossValue value = loss_at(loss, s);
    used += 1.0;
    curves[c].rows += 1.0;
    curves[c].psi2 += value.by_s * value.by_s * s;
    curves[c].slope += value.by_s + 2.0 * s * value.by_ss;
  }
  Eigen::VectorXd own = weights;
  Eigen::VectorXd influence = result.residuals;
  for (Eigen::Index k = 0; k < influence.size(); ++k)
    influence[k] *= loss_at(loss, influence[k] * influence[k]).by_s;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    for (std::size_t k = 0; k < rows.size(); ++k)
      own[static_cast<Eigen::Index>(k)] =
          rows[k].curve == static_cast<int>(c) ? weights[static_cast<Eigen::Index>(k)] : 0.0;
    curves[c].effective = effective_rows(rows, influence, own);
  }
  RowWorth worth{Eigen::VectorXd::Zero(weights.size()), Eigen::VectorXd::Zero(weights.size())};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (!(weights[row] > 0.0)) continue;
    const Sums& curve = curves[static_cast<std::size_t>(rows[k].curve)];
    constexpr double kLeastSlope = 0.05;  // of a loss that takes most rows for outliers
    const double slope = std::max(kLeastSlope, curve.slope / curve.rows);
    const double independent = std::max(1.0, curve.effective - moving * curve.rows / used);
    const double v =
        std::max(curve.psi2 / curve.rows, slope * slope) * std::max(1.0, curve.rows / independent);
    worth.bread[row] = weights[row] * slope;
    worth.filling[row] = v * weights[row] * weights[row];
  }
  return worth;
}

struct NormalMatrices {
  Eigen::MatrixXd bread, filling;
};

/// Sums over rows of the columns that move, batch by batch: a Jacobian may be large.
NormalMatrices sum_up(const RowMatrix& jacobian, const std::vector<int>& moving,
                      const RowWorth& worth) {
  const auto m = static_cast<Eigen::Index>(moving.size());
  NormalMatrices sums{Eigen::MatrixXd::Zero(m, m), Eigen::MatrixXd::Zero(m, m)};
  constexpr Eigen::Index kBatch = 256;
  Eigen::MatrixXd part;
  for (Eigen::Index first = 0; first < jacobian.rows(); first += kBatch) {
    const Eigen::Index count = std::min(kBatch, jacobian.rows() - first);
    part.resize(count, m);
    for (Eigen::Index c = 0; c < m; ++c)
      part.col(c) = jacobian.col(moving[static_cast<std::size_t>(c)]).segment(first, count);
    sums.bread.noalias() +=
        part.transpose() * worth.bread.segment(first, count).asDiagonal() * part;
    sums.filling.noalias() +=
        part.transpose() * worth.filling.segment(first, count).asDiagonal() * part;
  }
  return sums;
}

}  // namespace

void describe_optimum(const std::vector<const model::Parameter*>& parameters,
                      const std::vector<int>& free, const Eigen::VectorXd& weights,
                      const RobustLoss& loss, const std::vector<Row>& rows, FitResult& result) {
  const auto count = static_cast<Eigen::Index>(parameters.size());
  result.states.assign(parameters.size(), ParameterState::fixed);
  result.std_error.setZero(count);
  result.correlation.setZero(count, count);
  result.effective_rows = effective_rows(rows, result.residuals, weights);
  const Eigen::VectorXd roots = weights.cwiseSqrt();

  std::vector<int> moving;
  for (const int i : free) {
    const auto k = static_cast<std::size_t>(i);
    const double column = result.jacobian.col(i).cwiseProduct(roots).norm();
    if (!(column * std::max(1e-3, std::abs(result.parameters[i])) > 1e-9))
      result.states[k] = ParameterState::zero_gradient;
    else if (is_at_bound(*parameters[k], result.parameters[i]))
      result.states[k] = ParameterState::at_bound;
    else
      moving.push_back(i);
  }
  if (moving.empty()) return;
  const auto m = static_cast<Eigen::Index>(moving.size());
  const bool are_alike =
      loss.kind == Loss::none && ((weights.array() == 0.0) || (weights.array() == 1.0)).all();
  const RowWorth worth = are_alike
                             ? equal_worth(weights, static_cast<double>(m), result)
                             : worth_by_curve(weights, loss, rows, static_cast<double>(m), result);
  NormalMatrices sums = sum_up(result.jacobian, moving, worth);
  const Eigen::VectorXd norms = sums.bread.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse_norms = norms.cwiseInverse();
  sums.bread = inverse_norms.asDiagonal() * sums.bread * inverse_norms.asDiagonal();
  sums.filling = inverse_norms.asDiagonal() * sums.filling * inverse_norms.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(sums.bread);
  // directions in which the data say nothing are left out of the covariance; parameters that lie in
  // them are flat
  static constexpr double kFlat =
      1e-9;  // share of the largest eigenvalue of the scaled normal matrix
  const double largest = eigen.eigenvalues()[m - 1];
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(m, m);
  Eigen::VectorXd unseen = Eigen::VectorXd::Zero(m);
  for (Eigen::Index k = 0; k < m; ++k) {
    const Eigen::VectorXd direction = eigen.eigenvectors().col(k);
    if (eigen.eigenvalues()[k] > kFlat * largest)
      inverse += direction * direction.transpose() / eigen.eigenvalues()[k];
    else
      unseen += direction.cwiseAbs2();
  }
  const Eigen::MatrixXd covariance = inverse * sums.filling * inverse;
  for (Eigen::Index c = 0; c < m; ++c) {
    const int i = moving[static_cast<std::size_t>(c)];
    const auto k = static_cast<std::size_t>(i);
    result.std_error[i] = std::sqrt(covariance(c, c)) / norms[c];
    constexpr double kUnseen = 0.01;  // of a parameter's own direction
    result.states[k] = unseen[c] > kUnseen ? ParameterState::flat : ParameterState::free;
    for (Eigen::Index d = 0; d < m; ++d)
      result.correlation(i, moving[static_cast<std::size_t>(d)]) =
          covariance(c, d) / std::sqrt(covariance(c, c) * covariance(d, d));
  }
}

}  // namespace tenter::estimation
