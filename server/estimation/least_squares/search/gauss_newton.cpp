// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/search/gauss_newton.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

namespace tenter::estimation {
namespace {

class LineSearchFit {
 public:
  LineSearchFit(Objective& objective, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                const GaussNewtonOptions& options, Eigen::VectorXd& x)
      : objective_(objective), lower_(lower), upper_(upper), options_(options), x_(x) {}

  SearchResult run() {
    r_.resize(objective_.row_count());
    trial_r_.resize(objective_.row_count());
    j_.resize(objective_.row_count(), objective_.parameter_count());
    SearchResult result;
    if (!linearise()) return result;
    mu_ = options_.damping ? kFirstDamping : 0.0;
    result.end = SearchEnd::out_of_steps;
    while (result.iterations < options_.search.max_iterations) {
      ++result.iterations;
      const double before = r_.norm();
      const bool is_lower = take_step();
      result.cost = r_.squaredNorm();
      if (options_.search.on_iteration &&
          !options_.search.on_iteration(result.iterations, result.cost)) {
        result.end = SearchEnd::stopped;
        break;
      }
      if (!is_lower) {
        result.end = SearchEnd::no_descent;
        break;
      }
      if (before - r_.norm() <= options_.search.tolerance * before) {
        result.end = SearchEnd::converged;
        break;
      }
    }
    result.cost = r_.squaredNorm();
    return result;
  }

 private:
  static constexpr double kFirstDamping = 1e-3;
  static constexpr double kMostDamping = 1e6;
  static constexpr double kShortest = 1e-3;  // of a step

  bool linearise() { return objective_.evaluate(x_.data(), r_.data(), j_.data()); }

  /// One step with its line search; false where nothing lowers the cost.
  bool take_step() {
    while (true) {
      const Eigen::VectorXd step = solve();
      double fraction = largest_fraction(step);
      for (bool is_whole = true; fraction >= kShortest; fraction *= 0.5, is_whole = false) {
        const Eigen::VectorXd trial = (x_ + fraction * step).cwiseMax(lower_).cwiseMin(upper_);
        if (!objective_.evaluate(trial.data(), trial_r_.data(), nullptr) ||
            !(trial_r_.norm() < r_.norm()))
          continue;
        const Eigen::VectorXd before = x_;
        x_ = trial;
        if (linearise()) {
          if (is_whole && options_.damping) mu_ /= 10.0;
          return true;
        }
        x_ = before;
      }
      if (!options_.damping || mu_ > kMostDamping) return false;
      mu_ *= 10.0;
    }
  }

  /// The solution of (3.9), without what is pushed against its bound.
  Eigen::VectorXd solve() const {
    const Eigen::Index n = x_.size();
    const Eigen::VectorXd gradient = j_.transpose() * r_;
    std::vector<Eigen::Index> moving;
    for (Eigen::Index i = 0; i < n; ++i)
      if (!((x_[i] <= lower_[i] && gradient[i] > 0.0) || (x_[i] >= upper_[i] && gradient[i] < 0.0)))
        moving.push_back(i);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
    const auto m = static_cast<Eigen::Index>(moving.size());
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(r_.size() + m, m);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(r_.size() + m);
    right.head(r_.size()) = -r_;
    for (Eigen::Index c = 0; c < m; ++c) {
      j.col(c).head(r_.size()) = j_.col(moving[static_cast<std::size_t>(c)]);
      j(r_.size() + c, c) = std::sqrt(mu_) * j.col(c).norm();
    }
    const Eigen::VectorXd solution = j.colPivHouseholderQr().solve(right);
    for (Eigen::Index c = 0; c < m; ++c) step[moving[static_cast<std::size_t>(c)]] = solution[c];
    return step;
  }

  double largest_fraction(const Eigen::VectorXd& step) const {
    double fraction = 1.0;
    for (Eigen::Index i = 0; i < step.size(); ++i) {
      const double room = step[i] < 0.0 ? lower_[i] - x_[i] : upper_[i] - x_[i];
      if (step[i] != 0.0 && std::abs(step[i]) * fraction > std::abs(room))
        fraction = std::abs(room / step[i]);
    }
    return fraction;
  }

  Objective& objective_;
  const Eigen::VectorXd& lower_;
  const Eigen::VectorXd& upper_;
  const GaussNewtonOptions& options_;
  Eigen::VectorXd& x_;
  Eigen::VectorXd r_, trial_r_;
  RowMatrix j_;
  double mu_ = 0.0;
};

}  // namespace

SearchResult minimise_by_gauss_newton(Objective& objective, const Eigen::VectorXd& lower,
                                      const Eigen::VectorXd& upper,
                                      const GaussNewtonOptions& options, Eigen::VectorXd& x) {
  return LineSearchFit(objective, lower, upper, options, x).run();
}

}  // namespace tenter::estimation
