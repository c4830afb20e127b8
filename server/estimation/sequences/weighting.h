// SPDX-License-Identifier: GPL-3.0-or-later
// What every row of a fit to sequences counts in the cost, sum of weight r^2 with r in sigmas.
//
//   equal_protocols   every sequence counts the same, however many rows it has
//   by_noise          every row counts the same: least variance where sigmas and model are right
//   thesis            mu |x - x~|^2 + lambda |F - F~|^2 in metres and newtons, (3.6): a row weighs
//                     mu or lambda times its sigma^2. Of stretch mu = 0, of bending lambda = 0.
//                     Lengths are positions; torques and areas, which (3.6) lacks, weigh nothing.
//
// All times Sequence::weight, the w_i of (4.6); then scaled so that the mean of those above zero is
// one.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"
#include "server/estimation/residual_function.h"
#include "server/estimation/sequences/observations.h"

namespace tenter::estimation {

enum class WeightingRule { equal_protocols, by_noise, thesis };

struct ThesisFactors {
  double mu_1_m2 = 1.0;
  double lambda_1_N2 = 1.0;
};

struct Weighting {
  WeightingRule rule = WeightingRule::equal_protocols;
  std::vector<ThesisFactors> factors;  ///< of `thesis`: one a sequence
};

/// One a row. bad_input: factors that are not one a sequence, negative or no number, and where
/// nothing weighs anything.
Expected<Eigen::VectorXd> row_weights(const std::vector<Row>& rows,
                                      const std::vector<Sequence>& sequences,
                                      const Weighting& weighting);

}  // namespace tenter::estimation
