// SPDX-License-Identifier: GPL-3.0-or-later
// What an optimum says of its parameters: a word, a standard error and correlations for each.
//
// With unit errors of every row, weights w and a loss with psi = rho' r, the estimate scatters by
//
//   C = H^-1 M H^-1      H = sum w psi' j j'      M = sum v w^2 j j'     (sandwich; j: a row of J)
//
// where v = psi^2 is taken as its mean over a curve or sequence, not below what rows of unit error
// have, and times rows / (effective rows): neighbours of one loop are not independent, and where
// the model's form is wrong rows are further off than their sigma says. With equal weights and no
// loss this is the usual (J'J)^-1, inflated over all rows at once.
#pragma once

#include <vector>

#include "common/model/model.h"
#include "server/estimation/fit.h"

namespace tenter::estimation {

/// Fills states, std_error, correlation and effective_rows of `result` from its residuals, Jacobian
/// and parameters. `weights`: one a row.
void describe_optimum(const std::vector<const model::Parameter*>& parameters,
                      const std::vector<int>& free, const Eigen::VectorXd& weights,
                      const RobustLoss& loss, const std::vector<Row>& rows, FitResult& result);

}  // namespace tenter::estimation
