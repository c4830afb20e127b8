// SPDX-License-Identifier: GPL-3.0-or-later
// How much of the force does an effect account for? What lies between the prediction with it and
// the one without, both fitted, rms over the rms of the measured force.
//
//   D = r_with - r_without            size = |D| / |measured|, over the rows of forces
//
// Noise moves D only in the space Q that the effect adds to the model's own columns:
//
//   D* = D + Q Q' e*       e*: errors as they may have been
//
// so noise makes |D| too large by the mean of |Q Q' e*|^2, which is taken off, and the scatter of
// |D*| gives the 95 % interval. Errors are residuals of the larger model, each block's with a
// random sign: a block keeps its sign as a whole, since errors within one go together (design, step
// 3); what the model's own parameters took of them is given back. Or they are white and as large as
// what is left, where that is more: blocks say little of an effect that shows in one or two.
#pragma once

#include <vector>

#include "server/estimation/fit.h"

namespace tenter::diagnosis {

struct SizeInterval {
  bool of_force = true;  ///< else of the motion: the effect leaves the force alone
  double size = 0.0;
  double lo = 0.0;
  double hi = 0.0;
};

/// What a whitened row's residual of one is as a share of all that was measured of its kind; zero
/// on rows of other kinds.
struct SizeScale {
  Eigen::VectorXd force;
  Eigen::VectorXd motion;  ///< free stretches, positions; all zero where none was measured
};

/// Of two fits to the same rows, the larger model's Jacobian and states known.
SizeInterval effect_size(const std::vector<estimation::Row>& rows, int blocks,
                         const SizeScale& scale, const estimation::FitResult& without,
                         const estimation::FitResult& with, unsigned long long seed);

/// Both fits to the same data. Interval and size are equal where `with` adds no column of its own.
SizeInterval effect_size(const estimation::DataSet& data, const estimation::FitResult& without,
                         const estimation::FitResult& with, unsigned long long seed);

}  // namespace tenter::diagnosis
