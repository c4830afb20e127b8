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

/// What errors may have been, in coordinates of the space that an effect adds.
class Errors {
 public:
  Errors(const FitResult& with, const Eigen::MatrixXd& space, const std::vector<Row>& rows,
         int blocks)
      : rows_(rows), of_block_(Eigen::MatrixXd::Zero(space.cols(), blocks)) {
    const Eigen::VectorXd errors = without_leverage(with, blocks);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const auto at = static_cast<Eigen::Index>(r);
      of_block_.col(rows[r].block) += errors[at] * space.row(at).transpose();
    }
    const auto free = static_cast<double>(with.residuals.size() - free_columns(with).cols());
    sigma_ = with.residuals.norm() / std::sqrt(std::max(1.0, free));
  }

  /// Each block's with a random sign, as a whole.
  Eigen::VectorXd of_blocks(std::mt19937_64& engine) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(of_block_.rows());
    for (Eigen::Index b = 0; b < of_block_.cols(); ++b)
      sum += (engine() % 2 == 0 ? 1.0 : -1.0) * of_block_.col(b);
    return sum;
  }

  /// Of white noise as large as what is left: blocks say nothing of an effect that shows in one.
  Eigen::VectorXd of_readings(std::mt19937_64& engine) const {
    std::normal_distribution<double> normal(0.0, sigma_);
    Eigen::VectorXd draw(of_block_.rows());
    for (double& x : draw) x = normal(engine);
    return draw;
  }

 private:
  /// (I - H_bb)^-1/2 e_b of each block, H the projection on all columns of the fit: what the
  /// parameters took of a block's errors is given back, and white errors are as large as they were
  /// (Bell and McCaffrey 2002, CR2). What they took nearly all of cannot be known, and stays small.
  Eigen::VectorXd without_leverage(const FitResult& with, int blocks) const {
    constexpr double kLeast = 0.05;
    const Eigen::MatrixXd taken = range_of(free_columns(with), 1e-6);
    Eigen::VectorXd errors = with.residuals;
    std::vector<std::vector<Eigen::Index>> of_block(static_cast<std::size_t>(blocks));
    for (std::size_t r = 0; r < rows_.size(); ++r)
      of_block[static_cast<std::size_t>(rows_[r].block)].push_back(static_cast<Eigen::Index>(r));
    for (const std::vector<Eigen::Index>& block : of_block) {
      if (block.empty() || taken.cols() == 0) continue;
      const Eigen::MatrixXd q = taken(block, Eigen::indexing::all);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(q.transpose() * q);
      Eigen::VectorXd by = eigen.eigenvectors().transpose() * (q.transpose() * errors(block));
      for (Eigen::Index k = 0; k < by.size(); ++k) {
        const double share = eigen.eigenvalues()[k];
        by[k] *=
            share > 1e-12 ? (1.0 / std::sqrt(std::max(kLeast, 1.0 - share)) - 1.0) / share : 0.0;
      }
      errors(block) += q * (eigen.eigenvectors() * by);
    }
    return errors;
  }

  const std::vector<Row>& rows_;
  Eigen::MatrixXd of_block_;  ///< [coordinate](block)
  double sigma_ = 0.0;
};

/// |scale (apart + Q c)|^2 for coordinates c.
struct Square {
  Square(const Eigen::VectorXd& scale, const Eigen::VectorXd& apart, const Eigen::MatrixXd& space) {
    const Eigen::VectorXd weight = scale.cwiseAbs2();
    own = weight.dot(apart.cwiseAbs2());
    cross = space.transpose() * weight.cwiseProduct(apart);
    shifts = space.transpose() * weight.asDiagonal() * space;
  }
  double of_shift(const Eigen::VectorXd& c) const { return c.dot(shifts * c); }
  double moved_by(const Eigen::VectorXd& c) const { return own + 2.0 * cross.dot(c) + of_shift(c); }

  double own = 0.0;
  Eigen::VectorXd cross;
  Eigen::MatrixXd shifts;
};

/// Size and interval by draws of errors; `wider`: than the draws say.
SizeInterval size_over(const Square& square_of, const std::vector<Eigen::VectorXd>& shifts,
                       double wider) {
  const auto count = static_cast<double>(shifts.size());
  std::vector<double> moved;
  double inflation = 0.0;
  for (const Eigen::VectorXd& shift : shifts) {
    inflation += square_of.of_shift(shift) / count;
    moved.push_back(std::max(0.0, square_of.moved_by(shift)));
  }
  const auto without_noise = [&](double square) {
    return std::sqrt(std::max(0.0, square - inflation));
  };
  for (double& square : moved) square = without_noise(square);
  std::sort(moved.begin(), moved.end());
  const double truth = std::sqrt(square_of.own);  // in the world of the resamples
  SizeInterval result;
  result.size = without_noise(square_of.own);
  const double above = moved[moved.size() - 1 - moved.size() / 40] - truth;
  const double below = truth - moved[moved.size() / 40];
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
  const Errors errors(with, space, rows, blocks);
  std::mt19937_64 engine(seed);
  std::vector<Eigen::VectorXd> by_block, by_reading;
  for (int k = 0; k < kResamples; ++k) by_block.push_back(errors.of_blocks(engine));
  for (int k = 0; k < kResamples; ++k) by_reading.push_back(errors.of_readings(engine));
  // errors that go together are more than white ones: the wider of the two
  const auto size_of = [&](const Eigen::VectorXd& of_kind) {
    const Square square_of(of_kind, apart, space);
    const SizeInterval a = size_over(square_of, by_block, widening(blocks));
    const SizeInterval b = size_over(square_of, by_reading, 1.0);
    return a.hi - a.lo >= b.hi - b.lo ? a : b;
  };
  const SizeInterval of_force = size_of(scale.force);
  if (of_force.size >= kNothing || scale.motion.isZero(0.0)) return of_force;
  SizeInterval of_motion = size_of(scale.motion);
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
