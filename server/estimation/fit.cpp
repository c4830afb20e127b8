// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/model/catalogue.h"
#include "server/estimation/least_squares/bounded_least_squares.h"
#include "server/estimation/least_squares/covariance.h"
#include "server/estimation/least_squares/dissipation.h"
#include "server/estimation/least_squares/objective.h"
#include "server/estimation/least_squares/search/bounded_marquardt.h"
#include "server/estimation/least_squares/search/gauss_newton.h"
#include "server/estimation/least_squares/search/trust_region.h"

namespace tenter::estimation {
namespace {

/// A start strictly inside the bounds, so that no derivative is hidden by one.
double inside(const model::Parameter& p) {
  double value = p.value;
  if (p.lower) value = std::max(value, *p.lower);
  if (p.upper) value = std::min(value, *p.upper);
  return value;
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

Eigen::VectorXd weights_of(const ResidualFunction& evaluator, const FitOptions& options) {
  Eigen::VectorXd weights = evaluator.weights();
  if (weights.size() == 0) weights.setOnes(evaluator.row_count());
  if (options.weights.size() > 0) weights.array() *= options.weights.array();
  return weights;
}

/// Of the scaled free parameters; infinite where there is none.
struct Bounds {
  Eigen::VectorXd lower, upper;
};

Bounds bounds_of(const std::vector<const model::Parameter*>& parameters,
                 const std::vector<int>& free, const Eigen::VectorXd& scale) {
  Bounds bounds{Eigen::VectorXd::Constant(scale.size(), -kNoBound),
                Eigen::VectorXd::Constant(scale.size(), kNoBound)};
  for (std::size_t i = 0; i < free.size(); ++i) {
    const model::Parameter& p = *parameters[static_cast<std::size_t>(free[i])];
    const auto k = static_cast<Eigen::Index>(i);
    if (p.lower) bounds.lower[k] = *p.lower / scale[k];
    if (p.upper) bounds.upper[k] = *p.upper / scale[k];
  }
  return bounds;
}

void take(const SearchResult& found, FitResult& result) {
  result.iterations = found.iterations;
  result.stopped = found.end == SearchEnd::stopped;
  result.converged = found.is_converged();
  result.message = describe(found.end);
}

/// Makes the objective small from `x` on by the method that was asked for; false where it cannot
/// begin.
bool search(Objective& objective, const Bounds& bounds, const FitOptions& options,
            Eigen::VectorXd& x, FitResult& result) {
  const SearchOptions how{options.max_iterations, options.tolerance, options.on_iteration};
  switch (options.method) {
    case FitMethod::trust_region: {
      auto found = minimise_by_trust_region(objective, bounds.lower, bounds.upper, how, x);
      result.iterations = found.iterations;
      result.stopped = found.stopped;
      result.converged = found.converged;
      result.message = std::move(found.message);
      return !found.failed;
    }
    case FitMethod::bounded_marquardt:
      take(minimise_by_bounded_marquardt(objective, bounds.lower, bounds.upper, how, x), result);
      break;
    case FitMethod::gauss_newton:
    case FitMethod::gauss_newton_damped: {
      GaussNewtonOptions thesis{how, options.method == FitMethod::gauss_newton_damped};
      thesis.search.tolerance = options.residual_stop;
      take(minimise_by_gauss_newton(objective, bounds.lower, bounds.upper, thesis, x), result);
      break;
    }
  }
  return true;
}

FitResult fit_in_box(ResidualFunction& evaluator, const model::Model& start,
                     const FitOptions& options) {
  FitResult result;
  const auto parameters = parameters_of(start);
  Eigen::VectorXd all(static_cast<Eigen::Index>(parameters.size()));
  std::vector<int> free;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    all[static_cast<Eigen::Index>(i)] = inside(*parameters[i]);
    if (!parameters[i]->fixed) free.push_back(static_cast<int>(i));
  }
  const Eigen::VectorXd weights = weights_of(evaluator, options);
  evaluator.set_accuracy(Accuracy::stepping);
  if (!find_start(evaluator, parameters, all)) {
    result.message = "the model has no equilibrium at the start values";
    evaluator.set_accuracy(Accuracy::exact);
    return result;
  }
  if (!free.empty()) {
    Eigen::VectorXd scale(static_cast<Eigen::Index>(free.size()));
    Eigen::VectorXd x(scale.size());
    for (std::size_t i = 0; i < free.size(); ++i) {
      const double value = all[free[i]];
      scale[static_cast<Eigen::Index>(i)] = value != 0.0 ? std::abs(value) : 1.0;
      x[static_cast<Eigen::Index>(i)] = value / scale[static_cast<Eigen::Index>(i)];
    }
    evaluator.set_accuracy(Accuracy::stepping);
    Objective objective(evaluator, all, free, scale, weights, options.loss);
    const Bounds bounds = bounds_of(parameters, free, scale);
    if (!search(objective, bounds, options, x, result)) {
      result.message =
          "the model has no derivatives at the start values; where a direction is left free, a "
          "term must resist it";
      evaluator.set_accuracy(Accuracy::exact);
      return result;
    }
    for (std::size_t i = 0; i < free.size(); ++i)
      all[free[i]] = x[static_cast<Eigen::Index>(i)] * scale[static_cast<Eigen::Index>(i)];
  } else {
    result.converged = true;
    result.message = "nothing to fit";
  }
  result.parameters = all;
  evaluator.set_accuracy(Accuracy::exact);
  if (evaluator.evaluate(all, result.residuals, &result.jacobian) != mechanics::PathStatus::ok) {
    // what was good enough to step to is still the best that is known
    evaluator.set_accuracy(Accuracy::stepping);
    const auto status = evaluator.evaluate(all, result.residuals, &result.jacobian);
    evaluator.set_accuracy(Accuracy::exact);
    if (status != mechanics::PathStatus::ok) {
      result.message = "the model has no equilibrium at the optimum";
      return result;
    }
    result.converged = false;
    result.message = "at the optimum a frame comes to rest only roughly";
  }
  result.usable = true;
  result.chi2 = result.residuals.cwiseAbs2().dot(weights);
  describe_optimum(parameters, free, weights, options.loss, evaluator.rows(), result);
  return result;
}

/// Cost by one parameter at the bounded optimum, of the function itself.
double slope_by(ResidualFunction& evaluator, const Eigen::VectorXd& at, int parameter,
                const FitOptions& options) {
  Eigen::VectorXd residuals;
  RowMatrix jacobian;
  if (evaluator.evaluate(at, residuals, &jacobian) != mechanics::PathStatus::ok) return 0.0;
  const Eigen::VectorXd weights = weights_of(evaluator, options);
  double slope = 0.0;
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    const double r = residuals[k];
    slope += 2.0 * weights[k] * loss_at(options.loss, r * r).by_s * r * jacobian(k, parameter);
  }
  return slope;
}

}  // namespace

FitResult fit(ResidualFunction& evaluator, const model::Model& start, const FitOptions& options) {
  std::vector<FrictionPlaces> places = options.friction;
  model::Model from = start;
  const auto parameters = parameters_of(from);
  std::erase_if(places, [&](const FrictionPlaces& at) {
    return parameters[static_cast<std::size_t>(at.b)]->fixed;
  });
  if (places.empty()) return fit_in_box(evaluator, start, options);

  constexpr int kRounds = 4;
  constexpr double kInside = 0.9;  // of the bound: where b has a say again
  DissipativeFunction bounded(evaluator, places);
  const auto put_inside = [&](const Eigen::VectorXd& values, const FrictionPlaces& at) {
    parameters[static_cast<std::size_t>(at.b)]->value =
        kInside * growth_bound(values[at.a], values[at.c], values[at.tau]).b;
  };
  const Eigen::VectorXd given = parameter_values(from);
  for (const FrictionPlaces& at : bounded.beyond(given)) put_inside(given, at);
  FitResult result;
  for (int round = 1; round <= kRounds; ++round) {
    const int before = result.iterations;
    result = fit_in_box(bounded, from, options);
    result.iterations += before;
    if (!result.usable) return result;  // no parameters where the start cannot be evaluated
    const std::vector<FrictionPlaces> beyond = bounded.beyond(result.parameters);
    result.parameters = bounded.bounded(result.parameters);
    if (beyond.empty()) return result;
    for (const FrictionPlaces& at : beyond) {
      result.states[static_cast<std::size_t>(at.b)] = ParameterState::at_bound;
      result.std_error[at.b] = 0.0;
    }
    bool falls_inwards = false;
    for (std::size_t p = 0; p < parameters.size(); ++p)
      parameters[p]->value = result.parameters[static_cast<Eigen::Index>(p)];
    for (const FrictionPlaces& at : beyond) {
      if (!(slope_by(evaluator, result.parameters, at.b, options) > 0.0)) continue;
      falls_inwards = true;
      put_inside(result.parameters, at);
    }
    if (!falls_inwards || result.stopped) return result;
  }
  return result;
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
