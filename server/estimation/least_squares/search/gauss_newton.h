// SPDX-License-Identifier: GPL-3.0-or-later
// The thesis' outer loop (3.4.1): the linear least-squares problem (3.9) for the step, a line
// search from k(i) to its solution where the residual grows or a bound is violated, and an end
// where the residual |r| falls by less than a given part (1 %) between two iterations.
//
//   (J'J + mu D) dk = -J'r        D: diagonal of J'J; mu = 0, or additive Levenberg-Marquardt:
//                                 raised where no fraction of the step helps, lowered where all of
//                                 it does
//
// A step that would leave the bounds is shortened to where it meets the first one; a parameter that
// is at its bound and pushed against it stays there for the step. A fraction where the model has no
// equilibrium is one that does not help.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "server/estimation/least_squares/objective.h"
#include "server/estimation/least_squares/search/search_result.h"

namespace tenter::estimation {

struct GaussNewtonOptions {
  SearchOptions search{80, 0.01, {}};  ///< tolerance: of |r|, not of the cost
  bool damping = false;                ///< additive LM inside
};

/// `x`: start and result, scaled. Bounds of each: infinite where there is none; the start is
/// inside.
SearchResult minimise_by_gauss_newton(Objective& objective, const Eigen::VectorXd& lower,
                                      const Eigen::VectorXd& upper,
                                      const GaussNewtonOptions& options, Eigen::VectorXd& x);

}  // namespace tenter::estimation
