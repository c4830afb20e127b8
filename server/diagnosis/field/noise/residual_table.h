// SPDX-License-Identifier: GPL-3.0-or-later
// The residuals of a sheet by channel and frame, and which points are near which in the material.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/residual_function.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::diagnosis {

/// [channel][frame] of one sequence; NaN where nothing was seen.
using ResidualTable = std::vector<std::vector<double>>;

/// Of the sequence that is the `index`th of the rows'; the first so many channels.
ResidualTable residual_table(const estimation::Sequence& sequence, int index, int channels,
                             const std::vector<estimation::Row>& rows,
                             const Eigen::VectorXd& residuals);

/// Of each point the `most` nearest others, or as many as there are.
std::vector<std::vector<std::size_t>> nearest_points(const estimation::Sequence& sequence,
                                                     std::size_t most);

}  // namespace tenter::diagnosis
