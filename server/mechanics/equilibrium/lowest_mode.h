// SPDX-License-Identifier: GPL-3.0-or-later
// The direction of least stiffness of a matrix that is not positive definite.
//
// Inverse iteration on K + s I, with the smallest s of a geometric series that makes it positive
// definite; from a fixed start, so the same matrix gives the same bytes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/mechanics/sparse/factor.h"

namespace tenter::mechanics {

struct LowestMode {
  Eigen::VectorXd direction;  ///< of length one
  double stiffness = 0.0;     ///< direction . K direction
  double largest_diagonal = 0.0;
};

/// `factor` is analysed for `pattern` and is left with K + s I. A dozen solves and factorisations.
LowestMode lowest_mode(const SymmetricPattern& pattern, const std::vector<double>& values,
                       SparseFactor& factor);

/// A vector of length one with a part in every direction; the same one for the same size.
void spread_start(int size, Eigen::VectorXd& direction);

}  // namespace tenter::mechanics
