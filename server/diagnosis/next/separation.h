// SPDX-License-Identifier: GPL-3.0-or-later
// How far apart would two fitted models be on an experiment that was not done yet?
//
// With d the difference of what they predict there, in sigmas, J the Jacobian of one of them there
// and H = J0'J0 what the captures at hand know of its parameters, the one that is wrong may still
// give way, at the cost of fitting the old captures worse:
//
//   S = min over dp of |d + J dp|^2 + dp' H dp = d' (I + J H^-1 J')^-1 d
//
// the rise of chi2 that is expected of the wrong model: of the two directions the smaller counts.
#pragma once

#include <optional>
#include <vector>

#include "server/diagnosis/next/proposal.h"
#include "server/diagnosis/trials/trial.h"

namespace tenter::diagnosis {

/// What a fitted model says of an experiment.
struct Foretold {
  Eigen::VectorXd whitened;        ///< predictions in sigmas, but for what all models share
  estimation::RowMatrix jacobian;  ///< by the parameters that moving_columns() names
  double largest_force = 0.0;      ///< as in Separation
  /// Of each row; none: all are of one. Thousands of positions say nothing of what forces show.
  std::vector<int> kind = {};
};

/// Parameters that may give way, as a fit counts them.
std::vector<Eigen::Index> moving_columns(const Reference& at);

/// Of the first from the one that is closest to it, of as many models as were fitted to the same
/// captures. Nothing where that is no number. Pure.
std::optional<Separation> separation(const std::vector<Foretold>& foretold,
                                     const std::vector<const Reference*>& rivals);

}  // namespace tenter::diagnosis
