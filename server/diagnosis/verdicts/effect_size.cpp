// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/effect_size.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "server/diagnosis/verdicts/score.h"

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

/// Scale of rows that curves measured: readings from rest, in units of the channel.
Eigen::VectorXd share_of(const DataSet& data, const std::vector<Row>& rows,
                         const std::vector<std::size_t>& used) {
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rows.size()));
  double power = 0.0;
  for (const std::size_t r : used) {
    power += std::pow(measured_from_rest(data, rows[r]), 2);
    scale[static_cast<Eigen::Index>(r)] = data.sigma_of(rows[r]);
  }
  if (power > 0.0) scale /= std::sqrt(power);
  return scale;
}

/// How much wider 95 % of Student's t are than of a normal, to a hundredth from four blocks on: the
/// errors' own size is known from so many blocks only.
double widening(int blocks) {
  const double freedom = std::max(1, blocks - 1);
  return 1.0 + 1.36 / freedom + 1.0 / (freedom * freedom);
}

SizeInterval size_over(const Eigen::VectorXd& scale, const Eigen::VectorXd& apart,
                       const Eigen::MatrixXd& space, const Eigen::VectorXd& errors,
                       const std::vector<Row>& rows, int blocks, unsigned long long seed) {
  const auto square_of = [&](const Eigen::VectorXd& difference) {
    return scale.cwiseProduct(difference).squaredNorm();
  };
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
    inflation += square_of(shift) / kResamples;
    moved.push_back(square_of(apart + shift));
  }
  const auto without_noise = [&](double square) {
    return std::sqrt(std::max(0.0, square - inflation));
  };
  for (double& square : moved) square = without_noise(square);
  std::sort(moved.begin(), moved.end());
  const double truth = std::sqrt(square_of(apart));  // in the world of the resamples
  SizeInterval result;
  result.size = without_noise(square_of(apart));
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

SizeInterval effect_size(const std::vector<Row>& rows, int blocks, const SizeScale& scale,
                         const FitResult& without, const FitResult& with, unsigned long long seed) {
  constexpr double kNothing = 2e-3;
  const Eigen::VectorXd apart = with.residuals - without.residuals;
  const Eigen::MatrixXd space = added_space(without, with);
  // what a parameter takes from the errors, where those of a block go together
  const Eigen::VectorXd errors = with.residuals * std::sqrt(blocks / std::max(1.0, blocks - 1.0));
  const SizeInterval of_force = size_over(scale.force, apart, space, errors, rows, blocks, seed);
  if (of_force.size >= kNothing || scale.motion.isZero(0.0)) return of_force;
  SizeInterval of_motion = size_over(scale.motion, apart, space, errors, rows, blocks, seed);
  of_motion.of_force = false;
  return of_motion.size > of_force.size ? of_motion : of_force;
}

SizeInterval effect_size(const DataSet& data, const FitResult& without, const FitResult& with,
                         unsigned long long seed) {
  const std::vector<Row> rows = data.rows();
  const SizeScale scale = {share_of(data, rows, scored_rows(data, rows, -1)),
                           share_of(data, rows, stretch_rows(data, rows))};
  return effect_size(rows, data.block_count(), scale, without, with, seed);
}

}  // namespace tenter::diagnosis
