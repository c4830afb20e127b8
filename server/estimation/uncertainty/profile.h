// SPDX-License-Identifier: GPL-3.0-or-later
// How well the data determine a parameter, without the parabola of the covariance: the profile
// likelihood.
//
//   cost_i(v) = least cost of all fits in which parameter i is v
//   interval  = { v : cost_i(v) - cost <= 3.84 w },   w = rows' inflation
//
// 3.84 is the 95 % point of chi-squared with one degree of freedom. w is 1 where the rows are
// independent and as noisy as they say; correlated neighbours, and residuals larger than their
// sigma because the model's form is wrong, make it larger in the way of least_squares/covariance.h:
// max(1, chi2/rows) rows / (effective rows - parameters). From the optimum the walk goes outwards
// on both sides by refits that start from their neighbour, finds where the threshold is crossed,
// and looks on beyond for other basins, by fits that start there and are let go. A word for each:
//
//   bounded      the threshold is crossed on both sides
//   one_sided    on one side only: on the other it may go to its bound, or as far as looked
//   flat         on neither
//   multimodal   beyond a rise the cost falls again, below the threshold or the fit itself
//
// Every parameter has an evaluator of its own from the factory, so the bytes are the same for any
// number of threads. Cost: 10 to 40 refits a parameter.
//
//   auto make = [&] { return std::make_unique<Evaluator>(*Evaluator::make(model, data)); };
//   const std::vector<Profile> list = profiles(make, model, found, options, {.threads = 2});
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "server/estimation/fit.h"

namespace tenter::estimation {

/// Null where no evaluator can be made.
using MakeFunction = std::function<std::unique_ptr<ResidualFunction>()>;

enum class Determined { bounded, one_sided, flat, multimodal };
/// "bounded", "one_sided", "flat", "multimodal".
std::string_view words_of(Determined determined);

struct ProfilePoint {
  double value = 0.0;
  double rise = 0.0;  ///< of the cost above the fit's, over w
};

struct Profile {
  int parameter = 0;  ///< index, flat
  Determined determined = Determined::flat;
  std::optional<double> lo;  ///< ends of the 95 % interval; none: not found on that side
  std::optional<double> hi;
  bool found_better = false;  ///< some point lies below the fit: it was not the optimum
  int fits = 0;
  int failed = 0;                    ///< of them without a finite cost
  std::vector<ProfilePoint> points;  ///< by rising value, the fit itself among them
};

struct ProfileOptions {
  int threads = 1;
  std::vector<int> parameters;  ///< which; empty: all that are not fixed
  double rise = 3.841458820694124;
  double reach = 10.0;  ///< how far is looked: this many times the value, or 100 standard errors
  int scan = 4;         ///< points beyond the interval on each side, for other basins
};

/// `model` and `found` belong together, as do the `options` of that fit (its on_iteration is not
/// called). Order: as in ProfileOptions::parameters.
std::vector<Profile> profiles(const MakeFunction& make, const model::Model& model,
                              const FitResult& found, const FitOptions& options,
                              const ProfileOptions& profile_options = {});

/// w above.
double inflation(const FitResult& found, const FitOptions& options);

}  // namespace tenter::estimation
