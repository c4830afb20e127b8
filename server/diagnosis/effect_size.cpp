// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/effect_size.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "server/diagnosis/score.h"

namespace tenter::diagnosis {
namespace {

using estimation::DataSet;
using estimation::FitResult;
using estimation::Row;

constexpr int kResamples = 400;

/// Columns of what may move, each of length one.
Eigen::MatrixXd free_columns(const FitResult& fit) {
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < fit.states.size(); ++i) {
    const auto c = static_cast<Eigen::Index>(i);
    if (fit.states[i] == estimation::ParameterState::free && fit.jacobian.col(c).norm() > 0.0)
      free.push_back(c);
  }
  Eigen::MatrixXd columns(fit.jacobian.rows(), static_cast<Eigen::Index>(free.size()));
  for (Eigen::Index c = 0; c < columns.cols(); ++c)
    columns.col(c) = fit.jacobian.col(free[static_cast<std::size_t>(c)]).normalized();
  return columns;
}

Eigen::MatrixXd range_of(const Eigen::MatrixXd& columns, double threshold) {
  if (columns.cols() == 0) return columns;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  Eigen::Index rank = 0;
  for (Eigen::Index k = 0; k < std::min(columns.rows(), columns.cols()); ++k)
    if (std::abs(qr.matrixR()(k, k)) > threshold) ++rank;
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), rank);
}

/// Orthonormal, what `with` can move and `without` cannot.
Eigen::MatrixXd added_space(const FitResult& without, const FitResult& with) {
  constexpr double kSame = 1e-6;
  constexpr double kNew = 1e-3;  // shares of a column
  const Eigen::MatrixXd own = range_of(free_columns(without), kSame);
  Eigen::MatrixXd columns = free_columns(with);
  columns -= own * (own.transpose() * columns);
  return range_of(columns, kNew);
}

/// Sizes of differences over some of the rows.
class Share {
 public:
  Share(const DataSet& data, const std::vector<Row>& rows, const std::vector<std::size_t>& used)
      : scale_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rows.size()))) {
    double power = 0.0;
    for (const std::size_t r : used) {
      power += std::pow(measured_from_rest(data, rows[r]), 2);
      scale_[static_cast<Eigen::Index>(r)] = data.sigma_of(rows[r]);
    }
    if (power > 0.0) scale_ /= std::sqrt(power);
  }

  /// Squared, of whitened rows.
  double of(const Eigen::VectorXd& difference) const {
    return scale_.cwiseProduct(difference).squaredNorm();
  }

 private:
  Eigen::VectorXd scale_;
};

/// How much wider 95 % of Student's t are than of a normal, to a hundredth from four blocks on: the
/// errors' own size is known from so many blocks only.
double widening(int blocks) {
  const double freedom = std::max(1, blocks - 1);
  return 1.0 + 1.36 / freedom + 1.0 / (freedom * freedom);
}

SizeInterval size_over(const Share& share, const Eigen::VectorXd& apart,
                       const Eigen::MatrixXd& space, const Eigen::VectorXd& errors,
                       const std::vector<Row>& rows, int blocks, unsigned long long seed) {
  std::mt19937_64 engine(seed);
  std::vector<double> sign(static_cast<std::size_t>(blocks));
  std::vector<double> moved;
  double inflation = 0.0;
  Eigen::VectorXd flipped(errors.size());
  for (int k = 0; k < kResamples; ++k) {
    for (double& s : sign) s = engine() % 2 == 0 ? 1.0 : -1.0;
    for (std::size_t r = 0; r < rows.size(); ++r)
      flipped[static_cast<Eigen::Index>(r)] =
          sign[static_cast<std::size_t>(rows[r].block)] * errors[static_cast<Eigen::Index>(r)];
    const Eigen::VectorXd shift = space * (space.transpose() * flipped);
    inflation += share.of(shift) / kResamples;
    moved.push_back(share.of(apart + shift));
  }
  const auto without_noise = [&](double square) {
    return std::sqrt(std::max(0.0, square - inflation));
  };
  for (double& square : moved) square = without_noise(square);
  std::sort(moved.begin(), moved.end());
  const double truth = std::sqrt(share.of(apart));  // in the world of the resamples
  SizeInterval result;
  result.size = without_noise(share.of(apart));
  const double wider = widening(blocks);
  const double above = moved[kResamples - 1 - kResamples / 40] - truth;
  const double below = truth - moved[kResamples / 40];
  result.lo = std::max(0.0, result.size - wider * above);
  result.hi = result.size + wider * below;
  result.lo = std::min(result.lo, result.size);
  result.hi = std::max(result.hi, result.size);
  return result;
}

}  // namespace

SizeInterval effect_size(const DataSet& data, const FitResult& without, const FitResult& with,
                         unsigned long long seed) {
  constexpr double kNothing = 2e-3;
  const std::vector<Row> rows = data.rows();
  const Eigen::VectorXd apart = with.residuals - without.residuals;
  const Eigen::MatrixXd space = added_space(without, with);
  // what a parameter takes from the errors, where those of a block go together
  const double blocks = data.block_count();
  const Eigen::VectorXd errors = with.residuals * std::sqrt(blocks / std::max(1.0, blocks - 1.0));
  const auto over = [&](const std::vector<std::size_t>& used) {
    return size_over(Share(data, rows, used), apart, space, errors, rows, data.block_count(), seed);
  };
  SizeInterval of_force = over(scored_rows(data, rows, -1));
  if (of_force.size >= kNothing) return of_force;
  const std::vector<std::size_t> stretches = stretch_rows(data, rows);
  if (stretches.empty()) return of_force;
  SizeInterval of_stretch = over(stretches);
  of_stretch.of_force = false;
  return of_stretch.size > of_force.size ? of_stretch : of_force;
}

}  // namespace tenter::diagnosis
