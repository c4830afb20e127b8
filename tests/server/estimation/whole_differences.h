// SPDX-License-Identifier: GPL-3.0-or-later
// A Jacobian beside central differences of whole evaluations.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "server/estimation/residual_function.h"

namespace tenter::estimation::testing {

/// Columns `some` of the Jacobian at `at` follow differences to 1e-5, and the data tell something
/// of each: a parameter that falls to zero moves the residuals by more than one sigma.
inline void expect_whole_differences(ResidualFunction& function, const Eigen::VectorXd& at,
                                     const std::vector<int>& some) {
  Eigen::VectorXd residuals, high, low;
  RowMatrix jacobian;
  ASSERT_EQ(function.evaluate(at, residuals, &jacobian), mechanics::PathStatus::ok);
  for (const int p : some) {
    const double h = 1e-4 * at[p];
    Eigen::VectorXd up = at, down = at;
    up[p] += h;
    down[p] -= h;
    ASSERT_EQ(function.evaluate(up, high, nullptr), mechanics::PathStatus::ok);
    ASSERT_EQ(function.evaluate(down, low, nullptr), mechanics::PathStatus::ok);
    const Eigen::VectorXd column = (high - low) / (2.0 * h);
    EXPECT_GT(column.norm() * at[p], 1.0) << p;
    EXPECT_LT((jacobian.col(p) - column).norm(), 1e-5 * column.norm()) << p;
  }
}

}  // namespace tenter::estimation::testing
