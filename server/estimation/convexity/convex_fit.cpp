// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/convexity/convex_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

namespace tenter::estimation {
namespace {

/// J'J + mu D over all parameters; fixed ones get a one, so that the metric stays definite.
Eigen::MatrixXd damped(const Eigen::MatrixXd& normal, double mu,
                       const std::vector<bool>& is_fixed) {
  Eigen::MatrixXd metric = normal;
  const double largest = std::max(normal.diagonal().maxCoeff(), 1e-300);
  for (Eigen::Index i = 0; i < metric.rows(); ++i) {
    metric(i, i) += mu * std::max(normal(i, i), 1e-12 * largest);
    if (!is_fixed[static_cast<std::size_t>(i)]) continue;
    metric.row(i).setZero();
    metric.col(i).setZero();
    metric(i, i) = largest;
  }
  return metric;
}

/// Each row times the root of what its square counts.
void weigh(const ResidualFunction& evaluator, Eigen::VectorXd& r, RowMatrix* j) {
  const Eigen::VectorXd roots = evaluator.weights().cwiseSqrt();
  if (roots.size() == 0) return;
  r.array() *= roots.array();
  if (j != nullptr) j->array().colwise() *= roots.array();
}

}  // namespace

ConvexFit fit_convex(ResidualFunction& evaluator, const Eigen::VectorXd& start,
                     const ConvexityConstraints& constraints, const ConvexFitOptions& options) {
  ConvexFit result;
  ConvexProjection at = project_onto_convex(constraints, start);
  result.projections = 1;
  result.parameters = at.parameters;
  if (at.status != ConvexStatus::ok) {
    result.status = ConvexFitStatus::not_convex;
    return result;
  }
  Eigen::VectorXd r, trial;
  RowMatrix j;
  ++result.evaluations;
  if (evaluator.evaluate(result.parameters, r, &j) != mechanics::PathStatus::ok) {
    result.status = ConvexFitStatus::no_start;
    return result;
  }
  weigh(evaluator, r, &j);
  result.chi2 = r.squaredNorm();
  result.status = ConvexFitStatus::iterations_used;
  double mu = 1e-4;
  constexpr double kStuck = 1e10;  // of mu: steps too small to matter
  while (result.iterations < options.max_iterations) {
    const Eigen::MatrixXd normal = j.transpose() * j;
    Eigen::VectorXd slope = j.transpose() * r;
    for (Eigen::Index i = 0; i < slope.size(); ++i)
      if (constraints.is_fixed()[static_cast<std::size_t>(i)]) slope[i] = 0.0;
    const double before = result.chi2;
    bool kept = false;
    while (!kept && mu < kStuck) {
      const Eigen::MatrixXd metric = damped(normal, mu, constraints.is_fixed());
      const Eigen::VectorXd update = result.parameters - metric.ldlt().solve(slope);
      at = project_onto_convex(constraints, update,
                               options.metric == Metric::data ? metric : Eigen::MatrixXd());
      ++result.projections;
      const bool is_convex = at.status == ConvexStatus::ok;
      if (is_convex) ++result.evaluations;
      kept = is_convex &&
             evaluator.evaluate(at.parameters, trial, nullptr) == mechanics::PathStatus::ok;
      if (kept) weigh(evaluator, trial, nullptr);
      kept = kept && trial.squaredNorm() < result.chi2;
      mu = kept ? std::max(0.2 * mu, 1e-12) : 5.0 * mu;
    }
    if (!kept) {
      result.status = ConvexFitStatus::converged;
      return result;
    }
    result.parameters = at.parameters;
    ++result.iterations;
    ++result.evaluations;
    if (evaluator.evaluate(result.parameters, r, &j) != mechanics::PathStatus::ok) return result;
    weigh(evaluator, r, &j);
    result.chi2 = r.squaredNorm();
    if (options.on_iteration && !options.on_iteration(result.iterations, result.chi2)) {
      result.status = ConvexFitStatus::stopped;
      return result;
    }
    if (before - result.chi2 > options.tolerance * before) continue;
    result.status = ConvexFitStatus::converged;
    return result;
  }
  return result;
}

}  // namespace tenter::estimation
