// SPDX-License-Identifier: GPL-3.0-or-later
// A Jacobian beside differences, entry by entry.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "server/estimation/residual_function.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::testing {

/// Columns `which` at p; none of p's numbers is zero there.
inline void expect_derivatives(estimation::ResidualFunction& errors, const Eigen::VectorXd& p,
                               std::initializer_list<int> which) {
  Eigen::VectorXd residuals;
  estimation::RowMatrix jacobian;
  ASSERT_EQ(errors.evaluate(p, residuals, &jacobian), mechanics::PathStatus::ok);
  for (const int k : which) {
    const auto at = [&](double value) {
      Eigen::VectorXd moved = p;
      moved[k] = value;
      Eigen::VectorXd result;
      EXPECT_EQ(errors.evaluate(moved, result, nullptr), mechanics::PathStatus::ok);
      return result;
    };
    const Eigen::VectorXd slope = difference(at, p[k], 2e-6 * p[k]);
    Comparison compared("parameter " + std::to_string(k));
    for (Eigen::Index i = 0; i < slope.size(); ++i) compared.add(jacobian(i, k), slope[i]);
    compared.judge(1e-5);
  }
}

}  // namespace tenter::testing
