// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/least_squares/search/trust_region.h"

#include <ceres/ceres.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

namespace tenter::estimation {
namespace {

/// The objective as one Ceres cost of one parameter block.
class CeresCost final : public ceres::CostFunction {
 public:
  explicit CeresCost(Objective& objective) : objective_(objective) {
    set_num_residuals(objective.row_count());
    mutable_parameter_block_sizes()->push_back(objective.parameter_count());
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    return objective_.evaluate(x[0], residuals, jacobians ? jacobians[0] : nullptr);
  }

 private:
  Objective& objective_;
};

class Watch final : public ceres::IterationCallback {
 public:
  explicit Watch(const std::function<bool(int, double)>& report) : report_(report) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    return report_(s.iteration, 2.0 * s.cost) ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
  }

 private:
  const std::function<bool(int, double)>& report_;
};

TrustRegionResult by_ceres(Objective& objective, const Eigen::VectorXd& lower,
                           const Eigen::VectorXd& upper, const SearchOptions& options,
                           Eigen::VectorXd& x) {
  CeresCost cost(objective);
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(&cost, nullptr, x.data());
  for (int i = 0; i < objective.parameter_count(); ++i) {
    if (std::isfinite(lower[i])) problem.SetParameterLowerBound(x.data(), i, lower[i]);
    if (std::isfinite(upper[i])) problem.SetParameterUpperBound(x.data(), i, upper[i]);
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.tolerance;
  solver.parameter_tolerance = 1e-9;
  // from the first radius it takes more than Ceres' five halvings to shorten a step
  solver.max_num_consecutive_invalid_steps = 50;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  Watch watch(options.on_iteration);
  if (options.on_iteration) solver.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  TrustRegionResult result;
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.stopped = summary.termination_type == ceres::USER_FAILURE;
  result.failed = summary.termination_type == ceres::FAILURE && summary.iterations.size() <= 1;
  result.iterations = static_cast<int>(summary.iterations.size());
  result.message = result.converged ? "converged" : summary.message;
  return result;
}

/// The parameters that no bound holds back at x; empty where all are, or where a step of these
/// promises less than `tolerance` of the cost.
std::vector<int> worth_moving(Objective& objective, const Eigen::VectorXd& lower,
                              const Eigen::VectorXd& upper, double tolerance,
                              const Eigen::VectorXd& x) {
  const auto near = [&](double bound, double value) {
    return std::abs(value - bound) <= 1e-9 * std::max(1.0, std::abs(value));
  };
  bool is_at_bound = false;
  for (Eigen::Index i = 0; i < x.size(); ++i)
    is_at_bound = is_at_bound || near(lower[i], x[i]) || near(upper[i], x[i]);
  Eigen::VectorXd r(objective.row_count());
  RowMatrix j(objective.row_count(), objective.parameter_count());
  if (!is_at_bound || !objective.evaluate(x.data(), r.data(), j.data())) return {};
  const Eigen::VectorXd gradient = j.transpose() * r;
  std::vector<int> moving;
  for (int i = 0; i < objective.parameter_count(); ++i)
    if (!((near(lower[i], x[i]) && gradient[i] > 0.0) ||
          (near(upper[i], x[i]) && gradient[i] < 0.0)))
      moving.push_back(i);
  if (moving.empty() || static_cast<int>(moving.size()) == objective.parameter_count()) return {};
  Eigen::MatrixXd part(j.rows(), static_cast<Eigen::Index>(moving.size()));
  for (std::size_t k = 0; k < moving.size(); ++k)
    part.col(static_cast<Eigen::Index>(k)) = j.col(moving[k]);
  const Eigen::VectorXd step = part.colPivHouseholderQr().solve(-r);
  const double promised = r.squaredNorm() - (r + part * step).squaredNorm();
  return promised > tolerance * r.squaredNorm() ? moving : std::vector<int>{};
}

}  // namespace

TrustRegionResult minimise_by_trust_region(Objective& objective, const Eigen::VectorXd& lower,
                                           const Eigen::VectorXd& upper,
                                           const SearchOptions& options, Eigen::VectorXd& x) {
  TrustRegionResult result = by_ceres(objective, lower, upper, options, x);
  constexpr double kWorth = 10.0;  // tolerances: Ceres ends on what is below one
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds && result.converged; ++round) {
    const std::vector<int> moving =
        worth_moving(objective, lower, upper, kWorth * options.tolerance, x);
    if (moving.empty()) break;
    Objective part = objective.with_free(moving);
    Eigen::VectorXd x_part = x(moving);
    SearchOptions how = options;
    how.max_iterations = options.max_iterations - result.iterations;
    if (how.max_iterations <= 0) break;
    if (options.on_iteration)
      how.on_iteration = [&](int iteration, double cost) {
        return options.on_iteration(result.iterations + iteration, cost);
      };
    const TrustRegionResult next = by_ceres(part, lower(moving), upper(moving), how, x_part);
    x(moving) = x_part;
    result.converged = next.converged;
    result.stopped = next.stopped;
    result.iterations += next.iterations;
    result.message = next.message;
  }
  return result;
}

}  // namespace tenter::estimation
