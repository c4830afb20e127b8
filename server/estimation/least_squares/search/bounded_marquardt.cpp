// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/search/bounded_marquardt.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/estimation/least_squares/bounded_least_squares.h"

namespace tenter::estimation {
namespace {

constexpr double kFirstDamping = 1e-4;  // as Ceres' first radius
constexpr double kLeastDamping = 1e-12;
constexpr double kMostDamping = 1e8;
constexpr double kGood = 0.75;   // of what was promised: less damping
constexpr double kPoor = 0.25;   // more damping
constexpr double kTaken = 1e-3;  // less is no step

class Search {
 public:
  Search(Objective& objective, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
         const SearchOptions& options, Eigen::VectorXd& x)
      : objective_(objective), lower_(lower), upper_(upper), options_(options), x_(x) {}

  SearchResult run() {
    const Eigen::Index rows = objective_.row_count();
    r_.resize(rows);
    trial_r_.resize(rows);
    j_.resize(rows, objective_.parameter_count());
    x_ = x_.cwiseMax(lower_).cwiseMin(upper_);
    if (!linearise()) return result_;
    if (!report()) return end(SearchEnd::stopped);
    while (true) {
      if (promise(step(0.0)) <= options_.tolerance * cost_) return end(SearchEnd::converged);
      if (result_.iterations >= options_.max_iterations) return end(SearchEnd::out_of_steps);
      const double before = cost_;
      if (const auto stop = take_step()) return end(*stop);
      if (!report()) return end(SearchEnd::stopped);
      if (before - cost_ <= options_.tolerance * before) return end(SearchEnd::converged);
    }
  }

 private:
  bool linearise() {
    if (!objective_.evaluate(x_.data(), r_.data(), j_.data())) return false;
    cost_ = r_.squaredNorm();
    return true;
  }

  bool report() const {
    return !options_.on_iteration || options_.on_iteration(result_.iterations, cost_);
  }

  SearchResult end(SearchEnd how) {
    result_.end = how;
    result_.cost = cost_;
    return result_;
  }

  /// Tries shorter steps until one lowers the cost. A value says why to stop.
  std::optional<SearchEnd> take_step() {
    while (result_.iterations < options_.max_iterations) {
      ++result_.iterations;
      const Eigen::VectorXd d = step(damping_);
      const double promised = promise(d);
      if (!(promised > 0.0)) return SearchEnd::no_descent;
      const Eigen::VectorXd trial = (x_ + d).cwiseMax(lower_).cwiseMin(upper_);
      const bool has_rest = objective_.evaluate(trial.data(), trial_r_.data(), nullptr);
      const double gain = has_rest ? (cost_ - trial_r_.squaredNorm()) / promised : -1.0;
      if (gain > kTaken) {
        const Eigen::VectorXd before = x_;
        x_ = trial;
        if (linearise()) {
          if (gain > kGood) damping_ = std::max(kLeastDamping, 0.1 * damping_);
          if (gain < kPoor) damping_ = std::max(kFirstDamping, 4.0 * damping_);
          return std::nullopt;
        }
        x_ = before;
      }
      damping_ = std::max(kFirstDamping, 10.0 * damping_);
      if (damping_ > kMostDamping) return SearchEnd::no_descent;
    }
    return SearchEnd::out_of_steps;
  }

  Eigen::VectorXd step(double damping) const {
    const Eigen::Index n = x_.size();
    BoundedLeastSquares problem(static_cast<int>(n));
    problem.add(j_, -r_);
    if (damping > 0.0) {
      const Eigen::VectorXd lengths = std::sqrt(damping) * j_.colwise().norm().transpose();
      problem.add(lengths.asDiagonal().toDenseMatrix(), Eigen::VectorXd::Zero(n));
    }
    return problem.solve(lower_ - x_, upper_ - x_).x;
  }

  double promise(const Eigen::VectorXd& d) const { return cost_ - (r_ + j_ * d).squaredNorm(); }

  Objective& objective_;
  const Eigen::VectorXd& lower_;
  const Eigen::VectorXd& upper_;
  const SearchOptions& options_;
  Eigen::VectorXd& x_;
  Eigen::VectorXd r_, trial_r_;
  RowMatrix j_;
  double cost_ = 0.0;
  double damping_ = kFirstDamping;
  SearchResult result_;
};

}  // namespace

SearchResult minimise_by_bounded_marquardt(Objective& objective, const Eigen::VectorXd& lower,
                                           const Eigen::VectorXd& upper,
                                           const SearchOptions& options, Eigen::VectorXd& x) {
  return Search(objective, lower, upper, options, x).run();
}

}  // namespace tenter::estimation
