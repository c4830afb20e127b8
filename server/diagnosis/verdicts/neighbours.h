// SPDX-License-Identifier: GPL-3.0-or-later
// Does what is left go on from one reading to the next? Noise that is known from neighbouring
// readings alone cannot be held against them: white noise may be larger than they say, and may grow
// with the load.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/residual_function.h"

namespace tenter::diagnosis {

/// Sum of the products of neighbours within one block and channel, over its standard deviation
/// where signs are random: standard normal for white noise whatever its size from place to place
/// (many rows); 0 where no two are neighbours.
double neighbours_alike(const std::vector<estimation::Row>& rows, const Eigen::VectorXd& residuals);

}  // namespace tenter::diagnosis
