// SPDX-License-Identifier: GPL-3.0-or-later
// What the requests of a sheet's fit found (each empty where it was not asked for).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/estimation/heterogeneity/progressive_samples.h"
#include "server/estimation/limits/limit_fit.h"
#include "server/estimation/sequences/discretisation/grid_error.h"
#include "server/estimation/staged/start/multi_start.h"

namespace tenter::jobs {

/// The fit from random starts; costs are over at most `frames` frames of each capture.
struct StartsFound {
  int count = 0;  ///< random starts, beside the fit's own values
  std::uint64_t seed = 0;
  double widest = 0.0;  ///< largest factor on a parameter
  double share = 0.0;   ///< of the lowest cost: how much higher the best basin goes
  int frames = 0;
  double cost_of_fit = 0.0;  ///< from the fit's own values
  bool is_better = false;    ///< a random start went below that, and was taken
  int in_best_basin = 0;     ///< of all outcomes
  std::vector<estimation::StartOutcome> outcomes;  ///< lowest first; start 0: the fit's own values
};

struct ConvexFound {
  bool was_convex = false, is_convex = false;  ///< before and after, to rounding
  std::string term;                            ///< where it was least so before: its term,
  std::array<double, 2> strain = {0.0, 0.0};   ///< strains,
  double smallest = 0.0;                       ///< and eigenvalue, unit of a stiffness
  double cost_before = 0.0, cost_after = 0.0;  ///< over the fitted captures
  int projections = 0;
  int iterations = 0;
  std::string message;
};

struct SamplesFound {
  estimation::MaterialSamples samples;
  estimation::SampledFit fit;  ///< without its residuals and Jacobian
  std::string message;         ///< why there is none; else empty
};

struct LimitFound {
  std::string id;
  double given = 0.0;  ///< Psi_max of the starting model, J/m^2
  estimation::LimitFit fit;
  std::string message;
};

/// The fit to captures without the error of their grids.
struct GridFreeFound {
  struct OfCapture {
    double order = 0.0;  ///< of the convergence that was taken
    estimation::GridErrorSize force, position;
    int frames_without = 0;         ///< without an estimate
    estimation::Sequence measured;  ///< as it was captured
    estimation::GridError error;
  };
  int rounds = 0;
  bool settled = false;
  double change_sigmas = 0.0;  ///< of the estimate, by the last round
  double share_as_sigma = 0.0;
  std::vector<OfCapture> captures;  ///< one an input
};

struct Requested {
  std::optional<GridFreeFound> grid_free;
  std::optional<StartsFound> starts;
  std::optional<ConvexFound> convexity;
  std::optional<SamplesFound> samples;
  std::optional<LimitFound> limit;
  /// Errors and correlations, where a request knows of what hangs together.
  std::optional<estimation::FitResult> optimum;
};

}  // namespace tenter::jobs
