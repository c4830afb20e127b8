// SPDX-License-Identifier: GPL-3.0-or-later
// How many rows count as independent.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/residual_function.h"

namespace tenter::estimation {

/// Per block and channel, samples over twice the integrated autocorrelation time of the residuals,
/// at least one each (weights zero are skipped).
double effective_rows(const std::vector<Row>& rows, const Eigen::VectorXd& residuals,
                      const Eigen::VectorXd& weights);

}  // namespace tenter::estimation
