// SPDX-License-Identifier: GPL-3.0-or-later
// A fit whose energy stays convex (thesis 4.3): 1. an update of the parameters, 2. its convex
// projection, 3. equilibrium on all examples, until nothing is gained.
//
//   p_bar = p - (J'J + mu D)^-1 J'r,   D = diag J'J,   p+ = projection of p_bar
//
// p+ is kept where the cost falls, else mu grows.
//
//   Metric::parameters  projects by |p - p_bar|, as the thesis does
//   Metric::data        projects by J'J + mu D: p+ is then the best of all convex parameters
//                       for the update's own quadratic model, and a step is gained wherever
//                       there is one
//
// A point without equilibrium shortens the step. Rows count by evaluator.weights(). Deterministic.
//
//   auto convex = ConvexityConstraints::make(model);
//   const ConvexFit result = fit_convex(evaluator, start, *convex);
#pragma once

#include <Eigen/Core>
#include <functional>

#include "server/estimation/convexity/projection.h"
#include "server/estimation/residual_function.h"

namespace tenter::estimation {

enum class Metric { parameters, data };

struct ConvexFitOptions {
  Metric metric = Metric::data;
  int max_iterations = 80;
  double tolerance = 1e-7;  ///< relative fall of the cost below which the fit has converged
  /// Called after each step that was kept with its number and cost; returns false to stop.
  std::function<bool(int, double)> on_iteration = nullptr;
};

enum class [[nodiscard]] ConvexFitStatus{
    converged, iterations_used,
    no_start,    ///< no equilibrium at the projected start
    not_convex,  ///< the start could not be projected
    stopped      ///< by on_iteration
};

struct ConvexFit {
  ConvexFitStatus status = ConvexFitStatus::converged;
  Eigen::VectorXd parameters;
  double chi2 = 0.0;
  int iterations = 0;   ///< steps that were kept
  int evaluations = 0;  ///< of the residuals
  int projections = 0;
};

/// From `start` (all parameters, flat), projected first.
ConvexFit fit_convex(ResidualFunction& evaluator, const Eigen::VectorXd& start,
                     const ConvexityConstraints& constraints, const ConvexFitOptions& options = {});

}  // namespace tenter::estimation
