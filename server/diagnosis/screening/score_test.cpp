// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screening/score_test.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "server/estimation/least_squares/bounded_least_squares.h"

namespace tenter::diagnosis {

namespace {

double statistic(const Eigen::VectorXd& components, bool positive) {
  if (positive)
    return components[0] < 0.0 ? components.squaredNorm() : 0.0;  // less residual, not more
  return components.squaredNorm();
}

/// Amplitudes that may be, and the fall of chi2 that they bring; those of `free` where these may.
///
/// A column that adds nothing of its own (zero in `free`) stays where it is off.
double bounded(const Eigen::MatrixXd& columns, const Eigen::VectorXd& components,
               const std::vector<double>& least, Eigen::VectorXd& free) {
  const auto count = static_cast<Eigen::Index>(least.size());
  bool is_within = true;
  for (Eigen::Index c = 0; c < count; ++c)
    is_within = is_within && free[c] >= least[static_cast<std::size_t>(c)];
  if (is_within) return components.squaredNorm();
  Eigen::VectorXd lower(count);
  Eigen::VectorXd upper(count);
  Eigen::VectorXd norms(count);
  for (Eigen::Index c = 0; c < count; ++c) {
    const bool moves = free[c] != 0.0;
    norms[c] = std::max(columns.col(c).norm(), 1e-300);
    lower[c] = moves ? least[static_cast<std::size_t>(c)] * norms[c] : 0.0;
    upper[c] = moves ? estimation::kNoBound : 0.0;
  }
  estimation::BoundedLeastSquares problem(static_cast<int>(count));
  problem.add(columns * norms.cwiseInverse().asDiagonal(), -components);
  const estimation::BoundedSolution best = problem.solve(lower, upper);
  free = best.x.cwiseQuotient(norms);
  return std::max(0.0, components.squaredNorm() - best.residual * best.residual);
}

}  // namespace

Eigen::MatrixXd range_basis(const Eigen::MatrixXd& j) {
  if (j.cols() == 0) return Eigen::MatrixXd(j.rows(), 0);
  Eigen::MatrixXd scaled = j;
  for (Eigen::Index c = 0; c < j.cols(); ++c) {
    const double norm = j.col(c).norm();
    if (norm > 0.0) scaled.col(c) /= norm;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(1e-9);
  return qr.householderQ() * Eigen::MatrixXd::Identity(j.rows(), qr.rank());
}

double percentile(std::vector<double> values, double share) {
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

void settle(Ground& ground) {
  ground.twins -= ground.own * (ground.own.transpose() * ground.twins);
  ground.left = (ground.left - ground.own * (ground.own.transpose() * ground.left)).eval();
}

Projected project(Eigen::MatrixXd z, const std::vector<double>& least, const Eigen::MatrixXd& own,
                  const Eigen::VectorXd& residuals) {
  constexpr double kHidden = 1e-4;  // share of a column that must be new for it to count
  const Eigen::Index count = z.cols();
  Eigen::VectorXd norms(count);
  for (Eigen::Index c = 0; c < count; ++c) {
    norms[c] = z.col(c).norm();
    if (norms[c] > 0.0) z.col(c) /= norms[c];
  }
  z -= own * (own.transpose() * z);
  Projected result;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(z);
  qr.setThreshold(1e-6);
  Eigen::Index rank = 0;
  for (Eigen::Index k = 0; k < std::min(z.rows(), count); ++k)
    if (std::abs(qr.matrixR()(k, k)) > kHidden) ++rank;
  result.basis = qr.householderQ() * Eigen::MatrixXd::Identity(z.rows(), rank);
  result.amplitudes = Eigen::VectorXd::Zero(count);
  if (rank > 0) {
    const Eigen::VectorXd y = -(result.basis.transpose() * residuals);
    const Eigen::VectorXd x =
        qr.matrixR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>().solve(y);
    for (Eigen::Index k = 0; k < rank; ++k) {
      const Eigen::Index c = qr.colsPermutation().indices()[k];
      result.amplitudes[c] = x[k] / norms[c];
    }
    if (count == 1 && least[0] == 0.0) {
      result.positive = true;
      if (result.basis.col(0).dot(z.col(0)) < 0.0) result.basis.col(0) *= -1.0;
    }
  }
  return result;
}

std::optional<Tested> score_test(const Ground& ground, const Eigen::MatrixXd& z,
                                 const std::vector<double>& least, std::vector<double>* largest) {
  const auto count = static_cast<std::size_t>(ground.twins.cols());
  Projected p = project(z, least, ground.own, ground.left);
  if (p.basis.cols() == 0) return std::nullopt;
  const Eigen::VectorXd components = p.basis.transpose() * ground.left;
  const Eigen::MatrixXd twin_components = p.basis.transpose() * ground.twins;
  std::vector<double> null(count);
  for (std::size_t k = 0; k < count; ++k)
    null[k] = statistic(twin_components.col(static_cast<Eigen::Index>(k)), p.positive);
  const double scale = std::max(percentile(null, 0.95), 1e-9);
  if (largest)
    for (std::size_t k = 0; k < count; ++k)
      (*largest)[k] = std::max((*largest)[k], null[k] / scale);
  Tested score;
  score.gain = statistic(components, p.positive);
  score.df = static_cast<int>(p.basis.cols());
  score.u = score.gain / scale;
  score.within =
      std::min(score.gain, bounded(p.basis.transpose() * z, components, least, p.amplitudes));
  score.direction = p.basis * components;
  score.amplitudes = std::move(p.amplitudes);
  score.space = std::move(p.basis);
  return score;
}

double canonical_correlation(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.cols() == 0 || b.cols() == 0) return 0.0;
  const Eigen::MatrixXd cross = a.transpose() * b;
  return std::min(1.0, Eigen::JacobiSVD<Eigen::MatrixXd>(cross).singularValues()[0]);
}

}  // namespace tenter::diagnosis
