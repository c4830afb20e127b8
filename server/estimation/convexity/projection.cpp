// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/convexity/projection.h"

#include <cmath>
#include <vector>

#include "server/estimation/convexity/nearest_point.h"

namespace tenter::estimation {
namespace {

/// Parts of a problem that belong to the parameters that may move.
struct Free {
  std::vector<Eigen::Index> at;

  explicit Free(const std::vector<bool>& is_fixed) {
    for (std::size_t i = 0; i < is_fixed.size(); ++i)
      if (!is_fixed[i]) at.push_back(static_cast<Eigen::Index>(i));
  }
  Eigen::VectorXd of(const Eigen::VectorXd& all) const { return all(at); }
  Eigen::MatrixXd of_metric(const Eigen::MatrixXd& all) const {
    return all.size() > 0 ? Eigen::MatrixXd(all(at, at)) : all;
  }
};

/// What is nearer to its start than a solution has digits lies at its start: a term of zeros has no
/// size by which rounding could be told from a condition that is broken.
void settle(const Eigen::VectorXd& start, const Eigen::MatrixXd& metric, Eigen::VectorXd& x) {
  constexpr double kDigits = 1e-11;
  const Eigen::VectorXd weight = metric.size() > 0 ? Eigen::VectorXd(metric.diagonal().cwiseSqrt())
                                                   : Eigen::VectorXd::Ones(x.size());
  const double scale = weight.cwiseProduct(x).cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < x.size(); ++i)
    if (weight[i] * std::abs(x[i] - start[i]) < kDigits * scale) x[i] = start[i];
}

}  // namespace

ConvexProjection project_onto_convex(const ConvexityConstraints& constraints,
                                     const Eigen::VectorXd& parameters,
                                     const Eigen::MatrixXd& metric,
                                     const ProjectionOptions& options) {
  ConvexProjection result;
  result.parameters = parameters;
  const Free free(constraints.is_fixed());
  const Eigen::VectorXd start = free.of(parameters);
  const Eigen::MatrixXd free_metric = free.of_metric(metric);
  const Eigen::VectorXd sizes = constraints.sizes(parameters);
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> least;
  for (; result.rounds < options.max_rounds; ++result.rounds) {
    const std::size_t before = rows.size();
    constraints.add_broken(result.parameters, sizes, options.slack, rows, least);
    if (rows.size() == before) return result;
    result.rows = static_cast<int>(rows.size());
    Eigen::MatrixXd a(result.rows, start.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      a.row(static_cast<Eigen::Index>(i)) = free.of(rows[i]).transpose();
    const Eigen::Map<const Eigen::VectorXd> b(least.data(), result.rows);
    auto nearest = nearest_point(start, free_metric, a, b);
    if (!nearest) {
      result.status = ConvexStatus::infeasible;
      return result;
    }
    settle(start, free_metric, *nearest);
    result.parameters(free.at) = *nearest;
  }
  result.status = ConvexStatus::no_convergence;
  return result;
}

}  // namespace tenter::estimation
