// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/bounded_least_squares.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace tenter::estimation {
namespace {

constexpr double kRank = 1e-11;  // of the largest pivot, with columns of length one

/// The active set: which unknowns move, the others being held at a bound.
class ActiveSet {
 public:
  ActiveSet(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd lower,
            Eigen::VectorXd upper, Eigen::VectorXd start)
      : a_(a), b_(b), lower_(std::move(lower)), upper_(std::move(upper)), x_(std::move(start)) {
    moves_.assign(static_cast<std::size_t>(x_.size()), true);
    tolerance_ = 1e-14 * (a_.norm() * b_.norm() + 1e-300);
  }

  /// Walks to the minimum over what moves, holds what meets a bound, lets go of what a bound no
  /// longer stops, until there is none.
  void run() {
    const auto most = 10 * (x_.size() + 1);
    for (Eigen::Index turn = 0; turn < most; ++turn) {
      const Eigen::Index before = turn == 0 ? -1 : released_;
      minimise_over_moving();
      if (before >= 0 && !moves_[static_cast<std::size_t>(before)]) refused_ = before;
      if (!release_one()) return;
    }
  }

  const Eigen::VectorXd& x() const { return x_; }
  bool is_held(Eigen::Index i) const { return !moves_[static_cast<std::size_t>(i)]; }

 private:
  void minimise_over_moving() {
    while (true) {
      std::vector<Eigen::Index> moving;
      for (Eigen::Index i = 0; i < x_.size(); ++i)
        if (!is_held(i)) moving.push_back(i);
      if (moving.empty()) return;
      const Eigen::MatrixXd columns = a_(Eigen::indexing::all, moving);
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
      solver.setThreshold(kRank);
      solver.compute(columns);
      const Eigen::VectorXd step = solver.solve(b_ - a_ * x_);
      // as far as the first bound in the way
      double share = 1.0;
      Eigen::Index stop = -1;
      for (std::size_t k = 0; k < moving.size(); ++k) {
        const Eigen::Index i = moving[k];
        const double s = step[static_cast<Eigen::Index>(k)];
        const double room = s < 0.0 ? lower_[i] - x_[i] : upper_[i] - x_[i];
        if (s == 0.0 || !(std::abs(room) < share * std::abs(s))) continue;
        share = std::abs(room / s);
        stop = i;
      }
      for (std::size_t k = 0; k < moving.size(); ++k) {
        const Eigen::Index i = moving[k];
        x_[i] =
            std::clamp(x_[i] + share * step[static_cast<Eigen::Index>(k)], lower_[i], upper_[i]);
      }
      if (stop < 0) return;
      x_[stop] = step_sign(moving, step, stop) < 0.0 ? lower_[stop] : upper_[stop];
      moves_[static_cast<std::size_t>(stop)] = false;
    }
  }

  static double step_sign(const std::vector<Eigen::Index>& moving, const Eigen::VectorXd& step,
                          Eigen::Index which) {
    for (std::size_t k = 0; k < moving.size(); ++k)
      if (moving[k] == which) return step[static_cast<Eigen::Index>(k)];
    return 0.0;
  }

  /// The held unknown that would lower the cost most when let go.
  bool release_one() {
    const Eigen::VectorXd downhill = a_.transpose() * (b_ - a_ * x_);
    double best = tolerance_;
    released_ = -1;
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      if (!is_held(i) || i == refused_ || lower_[i] == upper_[i]) continue;
      const double gain = x_[i] <= lower_[i] ? downhill[i] : -downhill[i];
      if (gain <= best) continue;
      best = gain;
      released_ = i;
    }
    if (released_ < 0) return false;
    refused_ = -1;
    moves_[static_cast<std::size_t>(released_)] = true;
    return true;
  }

  const Eigen::MatrixXd& a_;
  const Eigen::VectorXd& b_;
  Eigen::VectorXd lower_, upper_, x_;
  std::vector<bool> moves_;
  double tolerance_ = 0.0;
  Eigen::Index released_ = -1;
  Eigen::Index refused_ = -1;  ///< was let go and went straight back: rounding
};

}  // namespace

BoundedLeastSquares::BoundedLeastSquares(int unknowns)
    : unknowns_(unknowns), triangle_(Eigen::MatrixXd::Zero(unknowns + 1, unknowns + 1)) {}

void BoundedLeastSquares::add(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index n = unknowns_ + 1;
  Eigen::MatrixXd stacked(n + a.rows(), n);
  stacked.topRows(n) = triangle_;
  stacked.bottomLeftCorner(a.rows(), unknowns_) = a;
  stacked.bottomRightCorner(a.rows(), 1) = b;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stacked);
  triangle_ = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
}

BoundedSolution BoundedLeastSquares::solve(const Eigen::VectorXd& lower,
                                           const Eigen::VectorXd& upper,
                                           const Eigen::VectorXd* start) const {
  BoundedSolution solution;
  const Eigen::Index n = unknowns_;
  // columns of length one, so that what is small is not taken for nothing
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double length = triangle_.col(i).norm();
    scale[i] = length > 0.0 ? 1.0 / length : 1.0;
  }
  const Eigen::MatrixXd a = triangle_.leftCols(n) * scale.asDiagonal();
  const Eigen::VectorXd b = triangle_.col(n);
  Eigen::VectorXd x = start ? *start : Eigen::VectorXd::Zero(n);
  x = x.cwiseMax(lower).cwiseMin(upper);
  ActiveSet set(a, b, lower.cwiseQuotient(scale), upper.cwiseQuotient(scale),
                x.cwiseQuotient(scale));
  set.run();
  solution.x = set.x().cwiseProduct(scale).cwiseMax(lower).cwiseMin(upper);
  solution.residual = (a * set.x() - b).norm();
  for (Eigen::Index i = 0; i < n; ++i) {
    solution.is_at_bound.push_back(set.is_held(i));
    // to the bit, whatever the scale did to it
    if (set.is_held(i))
      solution.x[i] = solution.x[i] - lower[i] < upper[i] - solution.x[i] ? lower[i] : upper[i];
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a);
  qr.setThreshold(kRank);
  solution.rank = static_cast<int>(qr.rank());
  return solution;
}

}  // namespace tenter::estimation
