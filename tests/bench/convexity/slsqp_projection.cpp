// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/convexity/slsqp_projection.h"

#ifdef TENTER_HAS_NLOPT
#include <nlopt.h>
#endif

#include <vector>

namespace tenter::bench {

#ifdef TENTER_HAS_NLOPT
namespace {

struct Case {
  const estimation::ConvexityConstraints& constraints;
  const Eigen::VectorXd& wanted;
  std::vector<Eigen::Index> free;
  int evaluations = 0;

  Eigen::VectorXd all(const double* x) const {
    Eigen::VectorXd p = wanted;
    for (std::size_t i = 0; i < free.size(); ++i) p[free[i]] = x[i];
    return p;
  }
};

double distance(unsigned n, const double* x, double* gradient, void* data) {
  Case& c = *static_cast<Case*>(data);
  ++c.evaluations;
  double sum = 0.0;
  for (unsigned i = 0; i < n; ++i) {
    const double d = x[i] - c.wanted[c.free[i]];
    sum += d * d;
    if (gradient != nullptr) gradient[i] = 2.0 * d;
  }
  return sum;
}

void eigenvalues(unsigned m, double* result, unsigned n, const double* x, double* gradient,
                 void* data) {
  const Case& c = *static_cast<Case*>(data);
  Eigen::VectorXd values;
  Eigen::MatrixXd by_p;
  c.constraints.smooth_values(c.all(x), values, gradient != nullptr ? &by_p : nullptr);
  for (unsigned i = 0; i < m; ++i) {
    result[i] = -values[static_cast<Eigen::Index>(i)];
    if (gradient == nullptr) continue;
    for (unsigned k = 0; k < n; ++k)
      gradient[i * n + k] = -by_p(static_cast<Eigen::Index>(i), c.free[k]);
  }
}

}  // namespace
#endif

SlsqpResult project_by_slsqp(const estimation::ConvexityConstraints& constraints,
                             const Eigen::VectorXd& parameters) {
  SlsqpResult result;
  result.parameters = parameters;
#ifdef TENTER_HAS_NLOPT
  Case c{constraints, parameters, {}, 0};
  for (std::size_t i = 0; i < constraints.is_fixed().size(); ++i)
    if (!constraints.is_fixed()[i]) c.free.push_back(static_cast<Eigen::Index>(i));
  Eigen::VectorXd values;
  constraints.smooth_values(parameters, values, nullptr);
  const auto n = static_cast<unsigned>(c.free.size());
  nlopt_opt solver = nlopt_create(NLOPT_LD_SLSQP, n);
  nlopt_set_min_objective(solver, distance, &c);
  const std::vector<double> slack(static_cast<std::size_t>(values.size()), 1e-9);
  nlopt_add_inequality_mconstraint(solver, static_cast<unsigned>(values.size()), eigenvalues, &c,
                                   slack.data());
  nlopt_set_xtol_rel(solver, 1e-9);
  nlopt_set_maxeval(solver, 500);
  std::vector<double> x;
  for (const Eigen::Index i : c.free) x.push_back(parameters[i]);
  double least = 0.0;
  result.ran = nlopt_optimize(solver, x.data(), &least) > 0;
  result.parameters = c.all(x.data());
  result.evaluations = c.evaluations;
  nlopt_destroy(solver);
#else
  static_cast<void>(constraints);
#endif
  return result;
}

}  // namespace tenter::bench
