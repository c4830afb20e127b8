// SPDX-License-Identifier: GPL-3.0-or-later
// Bounded least squares of a model's free parameters to a data set (Ceres, trust region), with
// covariance and a word for each parameter.
//
//   cost = sum over rows  weight * rho(r^2),   r = (predicted - measured) / sigma
//
// rho is the identity or a robust loss (Huber, Cauchy) for outliers. A point where the model finds
// no equilibrium shortens the step, it does not end the fit. Ceres' trust region, the thesis'
// Gauss-Newton with line search (3.4.1), or Marquardt's steps within the bounds.
// Deterministic, one thread.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "server/estimation/least_squares/effective_rows.h"
#include "server/estimation/prediction.h"

namespace tenter::estimation {

enum class ParameterState {
  free,
  fixed,  ///< by the document
  at_bound,
  zero_gradient,  ///< nothing in the data moves with it
  flat            ///< moved freely but the data do not determine it
};

enum class Loss { none, huber, cauchy };

struct RobustLoss {
  Loss kind = Loss::none;
  double scale = 1.345;  ///< in sigmas: 1.345 (Huber) or 2.385 (Cauchy) cost 5 % where there are no
                         ///< outliers
};

enum class FitMethod {
  trust_region,         ///< Ceres
  gauss_newton,         ///< thesis 3.4.1: line search, end when the residual falls by less than 1 %
  gauss_newton_damped,  ///< the same with additive Levenberg-Marquardt inside
  bounded_marquardt     ///< Levenberg-Marquardt, each step the exact one within the bounds
};

/// Where the parameters of one Dahl friction are among the flat ones.
struct FrictionPlaces {
  int a = 0, b = 0, c = 0, tau = 0;
};

struct FitOptions {
  Eigen::VectorXd weights;  ///< one per row, not negative; empty: all 1. Times evaluator.weights()
  int max_iterations = 80;
  double tolerance = 1e-7;      ///< relative fall of the cost below which the fit has converged
  double residual_stop = 0.01;  ///< the same of the residual's length, of Gauss-Newton
  FitMethod method = FitMethod::trust_region;
  RobustLoss loss;
  /// Frictions that shall lose work on every way (least_squares/dissipation.h); empty: none is
  /// bound.
  std::vector<FrictionPlaces> friction;
  /// Called after each iteration with its number and cost; returns false to stop.
  std::function<bool(int, double)> on_iteration;
};

struct FitResult {
  bool usable = false;  ///< parameters are at a finite cost
  bool converged = false;
  bool stopped = false;  ///< by on_iteration
  std::string message;
  int iterations = 0;
  double chi2 = 0.0;                   ///< sum of weighted squared residuals, whatever the loss
  Eigen::VectorXd parameters;          ///< all, flat
  Eigen::VectorXd residuals;           ///< of all rows, also those of weight zero
  RowMatrix jacobian;                  ///< rows x all parameters, at the optimum
  std::vector<ParameterState> states;  ///< at_bound also of a b that the dissipation bounds
  Eigen::VectorXd std_error;           ///< zero where not free
  RowMatrix correlation;               ///< of the free parameters at their places, zero elsewhere
  double effective_rows = 0.0;         ///< rows that count as independent
};

/// Starts from the model's values. Spline laws without a range must have been given one (see
/// adapt_spline_ranges).
FitResult fit(ResidualFunction& evaluator, const model::Model& start, const FitOptions& options);

/// Puts values, standard errors and 95 % intervals into the model.
void store(const FitResult& result, model::Model& model);

/// Gives every spline law with equal bounds the range of strain that the data reach under the
/// measured stretches.
void adapt_spline_ranges(model::Model& model, const std::vector<Curves>& curves);

/// Range of one strain measure over the measured stretches (its first strain).
std::pair<double, double> strain_range(const model::StrainMeasure& measure,
                                       const std::vector<Curves>& curves);

}  // namespace tenter::estimation
