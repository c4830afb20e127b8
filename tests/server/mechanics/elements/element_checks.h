// SPDX-License-Identifier: GPL-3.0-or-later
// Forces and stiffness of elements against differences.
#pragma once

#include <Eigen/Core>

#include "server/mechanics/elements/node_matrix.h"
#include "tests/server/mechanics/differences.h"

namespace tenter::mechanics {

struct Answer {
  double energy = 0.0;
  Eigen::VectorXd gradient;
};

/// `evaluate(x, matrix)` gives an Answer and adds the stiffness where a matrix is given. Every
/// seventh coordinate is moved. Returns the answer at x.
template <class Evaluate>
Answer check_derivatives(const Evaluate& evaluate, NodeMatrix& matrix, const Eigen::VectorXd& x,
                         double step, double relative) {
  Answer answer = evaluate(x, &matrix);
  tenter::testing::Comparison gradient("gradient");
  tenter::testing::Comparison stiffness("stiffness");
  for (Eigen::Index i = 0; i < x.size(); i += 7) {
    const auto moved = [&](double value) {
      Eigen::VectorXd y = x;
      y[i] = value;
      return evaluate(y, nullptr);
    };
    gradient.add(answer.gradient[i], tenter::testing::difference(
                                         [&](double v) { return moved(v).energy; }, x[i], step));
    const Eigen::VectorXd column = tenter::testing::difference(
        [&](double v) { return Eigen::VectorXd(moved(v).gradient); }, x[i], step);
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(x.size());
    Eigen::VectorXd product = unit;
    unit[i] = 1.0;
    matrix.multiply_add(unit.data(), product.data());
    for (Eigen::Index j = 0; j < x.size(); ++j) stiffness.add(product[j], column[j]);
  }
  gradient.judge(relative);
  stiffness.judge(relative);
  return answer;
}

}  // namespace tenter::mechanics
