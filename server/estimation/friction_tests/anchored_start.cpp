// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/anchored_start.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/estimation/least_squares/bounded_least_squares.h"

namespace tenter::estimation {
namespace {

double rms_of(AnchoredErrors& errors, const FrictionValues& values) {
  Eigen::VectorXd residuals;
  if (errors.evaluate(flat(values), residuals, nullptr) != mechanics::PathStatus::ok)
    return kNoBound;
  return std::sqrt(residuals.squaredNorm() /
                   static_cast<double>(std::max<Eigen::Index>(1, residuals.size())));
}

/// Two neighbouring parameters, in which the errors are linear, at the values of the others.
void solve_pair(AnchoredErrors& errors, FrictionValues& values, int first, double lower_second) {
  Eigen::VectorXd p = flat(values);
  p[first] = p[first + 1] = 0.0;
  Eigen::VectorXd residuals;
  RowMatrix jacobian;
  if (errors.evaluate(p, residuals, &jacobian) != mechanics::PathStatus::ok) return;
  BoundedLeastSquares problem(2);
  problem.add(jacobian.middleCols(first, 2), -residuals);
  const Eigen::Vector2d lower(0.0, lower_second);
  const Eigen::Vector2d upper(kNoBound, kNoBound);
  const BoundedSolution found = problem.solve(lower, upper);
  p.segment(first, 2) = found.x;
  values = values_of(p);
}

/// From a reading's anchor to it.
double longest_way(const std::vector<AnchoredReading>& readings) {
  double way = 0.0;
  for (const AnchoredReading& r : readings) way = std::max(way, std::abs(r.strain - r.anchor));
  return way;
}

void look_for_tau(AnchoredErrors& errors, FrictionValues& values) {
  const double way = longest_way(errors.readings());
  constexpr int kValues = 60;
  double best = kNoBound;
  FrictionValues trial = values;
  for (int i = 0; i < kValues; ++i) {
    trial.tau = std::max(way * 1e-3 * std::pow(3e3, i / (kValues - 1.0)), 1e-6);
    const double rms = rms_of(errors, trial);
    if (rms < best) {
      best = rms;
      values.tau = trial.tau;
    }
  }
}

}  // namespace

AnchoredStart anchored_start(AnchoredErrors& errors, const model::Model& model,
                             const FrictionValues* stiffness) {
  AnchoredStart start;
  const auto keep = [&](const FrictionValues& values) {
    start.stages.push_back(values);
    start.rms_load.push_back(rms_of(errors, values));
  };
  FrictionValues values;
  values.tau = std::max(1e-4 * longest_way(errors.readings()), 1e-6);
  if (stiffness != nullptr) {
    values.k1 = stiffness->k1;
    values.k2 = stiffness->k2;
  } else {
    solve_pair(errors, values, kK1, -kNoBound);
  }
  keep(values);
  solve_pair(errors, values, kA, 0.0);
  keep(values);
  look_for_tau(errors, values);
  keep(values);
  model::Model whole = with_values(model, values);
  if (stiffness != nullptr)
    for (model::Parameter& p : whole.terms.front().law.parameters) p.fixed = true;
  start.papers = fit(errors, whole, {});
  keep(start.papers.usable ? values_of(start.papers.parameters) : values);
  return start;
}

std::vector<FrictionValues> starts_of(const AnchoredStart& start, const AnchoredErrors& anchored) {
  const double way = longest_way(anchored.readings());
  std::vector<FrictionValues> starts = {start.stages.back()};
  for (const double share : {0.01, 0.03, 0.1, 0.3}) {
    starts.push_back(start.stages.back());
    starts.back().tau = share * way;
  }
  return starts;
}

FitResult fit_from(const std::vector<FrictionValues>& starts, ResidualFunction& errors,
                   const model::Model& model, const FitOptions& options) {
  FitOptions rough = options;
  rough.max_iterations = 8;
  FitResult best;
  for (const FrictionValues& from : starts) {
    FitResult found = fit(errors, with_values(model, from), rough);
    if (found.usable && (!best.usable || found.chi2 < best.chi2)) best = std::move(found);
  }
  if (!best.usable) return best;
  return fit(errors, with_values(model, values_of(best.parameters)), options);
}

}  // namespace tenter::estimation
