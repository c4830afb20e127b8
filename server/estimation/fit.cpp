// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/fit.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/model/catalogue.h"

namespace tenter::estimation {
namespace {

/// All rows as one Ceres cost of one parameter block: the free parameters, each divided by its
/// scale.
class AllRows final : public ceres::CostFunction {
 public:
  AllRows(ResidualFunction& evaluator, Eigen::VectorXd& all, const std::vector<int>& free,
          const Eigen::VectorXd& scale, const Eigen::VectorXd& weights)
      : evaluator_(evaluator), all_(all), free_(free), scale_(scale), weights_(weights) {
    set_num_residuals(evaluator.row_count());
    mutable_parameter_block_sizes()->push_back(static_cast<int>(free.size()));
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    for (std::size_t i = 0; i < free_.size(); ++i)
      all_[free_[i]] = x[0][i] * scale_[static_cast<Eigen::Index>(i)];
    const bool wants_jacobian = jacobians && jacobians[0];
    if (evaluator_.evaluate(all_, r_, wants_jacobian ? &j_ : nullptr) != mechanics::PathStatus::ok)
      return false;
    const bool weighted = weights_.size() > 0;
    Eigen::Map<Eigen::VectorXd> out(residuals, r_.size());
    out = weighted ? Eigen::VectorXd(r_.cwiseProduct(weights_)) : r_;
    if (!wants_jacobian) return true;
    Eigen::Map<RowMatrix> out_j(jacobians[0], r_.size(), static_cast<Eigen::Index>(free_.size()));
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      out_j.col(column) = j_.col(free_[i]) * scale_[column];
      if (weighted) out_j.col(column).array() *= weights_.array();
    }
    return out_j.allFinite();
  }

 private:
  ResidualFunction& evaluator_;
  Eigen::VectorXd& all_;
  const std::vector<int>& free_;
  const Eigen::VectorXd& scale_;
  const Eigen::VectorXd& weights_;
  mutable Eigen::VectorXd r_;
  mutable RowMatrix j_;
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

/// A start strictly inside the bounds, so that no derivative is hidden by one.
double inside(const model::Parameter& p) {
  double value = p.value;
  if (p.lower) value = std::max(value, *p.lower);
  if (p.upper) value = std::min(value, *p.upper);
  return value;
}

bool is_at_bound(const model::Parameter& p, double value) {
  const double slack = 1e-7 * std::max(1.0, std::abs(value));
  if (p.lower && value - *p.lower <= slack) return true;
  return p.upper && *p.upper - value <= slack;
}

/// A start at which the model has an equilibrium: where it has none, couplings that may take either
/// sign are weakened.
bool find_start(ResidualFunction& evaluator, const std::vector<const model::Parameter*>& parameters,
                Eigen::VectorXd& all) {
  const Eigen::VectorXd wanted = all;
  Eigen::VectorXd residuals;
  for (const double share : {1.0, 0.3, 0.1, 0.0}) {
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (!parameters[i]->fixed && !parameters[i]->lower)
        all[static_cast<Eigen::Index>(i)] = share * wanted[static_cast<Eigen::Index>(i)];
    if (evaluator.evaluate(all, residuals, nullptr) == mechanics::PathStatus::ok) return true;
  }
  return false;
}

/// Fills states, standard errors and correlations from the Jacobian at the optimum.
void describe(const std::vector<const model::Parameter*>& parameters, const std::vector<int>& free,
              const FitOptions& options, const std::vector<Row>& rows, FitResult& result) {
  const auto count = static_cast<Eigen::Index>(parameters.size());
  result.states.assign(parameters.size(), ParameterState::fixed);
  result.std_error.setZero(count);
  result.correlation.setZero(count, count);
  const Eigen::VectorXd weights =
      options.weights.size() > 0 ? options.weights : Eigen::VectorXd::Ones(result.residuals.size());
  result.effective_rows = effective_rows(rows, result.residuals, weights);

  std::vector<int> moving;
  for (const int i : free) {
    const auto k = static_cast<std::size_t>(i);
    const double column = result.jacobian.col(i).cwiseProduct(weights).norm();
    if (!(column * std::max(1e-3, std::abs(result.parameters[i])) > 1e-9))
      result.states[k] = ParameterState::zero_gradient;
    else if (is_at_bound(*parameters[k], result.parameters[i]))
      result.states[k] = ParameterState::at_bound;
    else
      moving.push_back(i);
  }
  if (moving.empty()) return;
  const auto m = static_cast<Eigen::Index>(moving.size());
  Eigen::MatrixXd j(result.residuals.size(), m);
  Eigen::VectorXd norms(m);
  for (Eigen::Index c = 0; c < m; ++c) {
    j.col(c) = result.jacobian.col(moving[static_cast<std::size_t>(c)]).cwiseProduct(weights);
    norms[c] = j.col(c).norm();
    j.col(c) /= norms[c];
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(j.transpose() * j);
  // directions in which the data say nothing are left out of the covariance; parameters that lie in
  // them are flat
  static constexpr double kFlat =
      1e-9;  // share of the largest eigenvalue of the scaled normal matrix
  const double largest = eigen.eigenvalues()[m - 1];
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(m, m);
  Eigen::VectorXd unseen = Eigen::VectorXd::Zero(m);
  for (Eigen::Index k = 0; k < m; ++k) {
    const Eigen::VectorXd direction = eigen.eigenvectors().col(k);
    if (eigen.eigenvalues()[k] > kFlat * largest)
      covariance += direction * direction.transpose() / eigen.eigenvalues()[k];
    else
      unseen += direction.cwiseAbs2();
  }
  // one sigma of a row stands for rows/effective_rows of them, and more where the model's form is
  // wrong
  const double used = weights.sum();
  const double inflation = std::max(1.0, result.chi2 / std::max(1.0, used)) * used /
                           std::max(1.0, result.effective_rows - static_cast<double>(m));
  for (Eigen::Index c = 0; c < m; ++c) {
    const int i = moving[static_cast<std::size_t>(c)];
    const auto k = static_cast<std::size_t>(i);
    result.std_error[i] = std::sqrt(covariance(c, c) * std::max(1.0, inflation)) / norms[c];
    constexpr double kUnseen = 0.01;  // of a parameter's own direction
    result.states[k] = unseen[c] > kUnseen ? ParameterState::flat : ParameterState::free;
    for (Eigen::Index d = 0; d < m; ++d)
      result.correlation(i, moving[static_cast<std::size_t>(d)]) =
          covariance(c, d) / std::sqrt(covariance(c, c) * covariance(d, d));
  }
}

}  // namespace

FitResult fit(ResidualFunction& evaluator, const model::Model& start, const FitOptions& options) {
  FitResult result;
  const auto parameters = parameters_of(start);
  Eigen::VectorXd all(static_cast<Eigen::Index>(parameters.size()));
  std::vector<int> free;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    all[static_cast<Eigen::Index>(i)] = inside(*parameters[i]);
    if (!parameters[i]->fixed) free.push_back(static_cast<int>(i));
  }
  if (!find_start(evaluator, parameters, all)) {
    result.message = "the model has no equilibrium at the start values";
    return result;
  }
  if (!free.empty()) {
    Eigen::VectorXd scale(static_cast<Eigen::Index>(free.size()));
    std::vector<double> x(free.size());
    for (std::size_t i = 0; i < free.size(); ++i) {
      const double value = all[free[i]];
      scale[static_cast<Eigen::Index>(i)] = value != 0.0 ? std::abs(value) : 1.0;
      x[i] = value / scale[static_cast<Eigen::Index>(i)];
    }
    AllRows rows(evaluator, all, free, scale, options.weights);
    ceres::Problem::Options ownership;
    ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(ownership);
    problem.AddResidualBlock(&rows, nullptr, x.data());
    for (std::size_t i = 0; i < free.size(); ++i) {
      const model::Parameter& p = *parameters[static_cast<std::size_t>(free[i])];
      const double s = scale[static_cast<Eigen::Index>(i)];
      if (p.lower) problem.SetParameterLowerBound(x.data(), static_cast<int>(i), *p.lower / s);
      if (p.upper) problem.SetParameterUpperBound(x.data(), static_cast<int>(i), *p.upper / s);
    }
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_QR;
    solver.max_num_iterations = options.max_iterations;
    solver.function_tolerance = options.tolerance;
    solver.parameter_tolerance = 1e-9;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    Watch watch(options.on_iteration);
    if (options.on_iteration) solver.callbacks.push_back(&watch);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    for (std::size_t i = 0; i < free.size(); ++i)
      all[free[i]] = x[i] * scale[static_cast<Eigen::Index>(i)];
    result.converged = summary.termination_type == ceres::CONVERGENCE;
    result.stopped = summary.termination_type == ceres::USER_FAILURE;
    result.iterations = static_cast<int>(summary.iterations.size());
    result.message = result.converged ? "converged" : summary.message;
  } else {
    result.converged = true;
    result.message = "nothing to fit";
  }
  result.parameters = all;
  if (evaluator.evaluate(all, result.residuals, &result.jacobian) != mechanics::PathStatus::ok) {
    result.message = "the model has no equilibrium at the optimum";
    return result;
  }
  result.usable = true;
  result.chi2 = options.weights.size() > 0
                    ? result.residuals.cwiseProduct(options.weights).squaredNorm()
                    : result.residuals.squaredNorm();
  describe(parameters, free, options, evaluator.rows(), result);
  return result;
}

double effective_rows(const std::vector<Row>& rows, const Eigen::VectorXd& residuals,
                      const Eigen::VectorXd& weights) {
  double total = 0.0;
  std::size_t first = 0;
  std::vector<double> x;
  while (first < rows.size()) {
    std::size_t last = first;
    x.clear();
    while (last < rows.size() && rows[last].block == rows[first].block &&
           rows[last].channel == rows[first].channel && rows[last].curve == rows[first].curve) {
      if (weights[static_cast<Eigen::Index>(last)] > 0.0)
        x.push_back(residuals[static_cast<Eigen::Index>(last)]);
      ++last;
    }
    first = last;
    const auto n = x.size();
    if (n == 0) continue;
    double variance = 0.0;
    for (const double v : x) variance += v * v;
    double time = 1.0;
    // sum pairs of lags while they are positive (Geyer's initial positive sequence); the mean is
    // kept in: a residual that keeps its sign over the block is one piece of evidence
    for (std::size_t lag = 1; lag + 1 < n && variance > 0.0; lag += 2) {
      double pair = 0.0;
      for (std::size_t k = lag; k <= lag + 1; ++k)
        for (std::size_t i = 0; i + k < n; ++i) pair += x[i] * x[i + k] / variance;
      if (pair <= 0.0) break;
      time += 2.0 * pair;
    }
    total += std::clamp(static_cast<double>(n) / time, 1.0, static_cast<double>(n));
  }
  return total;
}

void store(const FitResult& result, model::Model& model) {
  const auto parameters = parameters_of(model);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    model::Parameter& p = *parameters[i];
    p.value = result.parameters[k];
    p.std_error.reset();
    p.interval_lo.reset();
    p.interval_hi.reset();
    if (result.states[i] != ParameterState::free) continue;
    const double half = 1.96 * result.std_error[k];
    p.std_error = result.std_error[k];
    p.interval_lo = p.lower ? std::max(*p.lower, p.value - half) : p.value - half;
    p.interval_hi = p.upper ? std::min(*p.upper, p.value + half) : p.value + half;
  }
}

std::pair<double, double> strain_range(const model::StrainMeasure& description,
                                       const std::vector<Curves>& curves) {
  const auto measure = mechanics::StrainMeasure::make(description);
  double lo = 0.0;
  double hi = 0.0;
  mechanics::StrainValue value;
  for (const Curves& c : curves) {
    const mechanics::HomogeneousStrain kinematics(c.path.axis_angle_rad);
    for (const Eigen::Vector3d& q : c.path.q) {
      measure->evaluate(kinematics.c(q), value);
      for (int i = 0; i < measure->count(); ++i) {
        lo = std::min(lo, value.value[i]);
        hi = std::max(hi, value.value[i]);
      }
    }
  }
  return {lo, hi};
}

void adapt_spline_ranges(model::Model& model, const std::vector<Curves>& curves) {
  for (model::Term& term : model.terms) {
    const model::LawRow* row = model::find_law(term.law.name);
    if (row == nullptr || !row->spline || term.law.range_hi > term.law.range_lo) continue;
    if (!mechanics::StrainMeasure::make(term.strain)) continue;  // curves do not reach it
    std::tie(term.law.range_lo, term.law.range_hi) = strain_range(term.strain, curves);
    if (!(term.law.range_hi > term.law.range_lo)) term.law.range_hi = term.law.range_lo + 1e-3;
  }
}

}  // namespace tenter::estimation
