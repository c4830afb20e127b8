// SPDX-License-Identifier: GPL-3.0-or-later
// Steps with an old factor that learn from what they see: the limited-memory BFGS update of the
// inverse stiffness, on top of a factorisation (Nocedal, Wright, Numerical Optimization, 7.2).
//
//   y_k = g_(k+1) - g_k, s_k = x_(k+1) - x_k, r_k = 1/(y_k . s_k)
//   H_(k+1) = (I - r s y') H_k (I - r y s') + r s s',     H_0 = K^-1 of the factor
//
// Where the stiffness jumps between iterates (friction that turns round) the secant knows what the
// tangent does not. Pairs without positive curvature are left out, so that H stays definite.
//
//   Secants secants;                                  // kept between solves: allocates once
//   secants.forget(unknowns);                         // after each factorisation
//   secants.solve(factor, gradient, step);            // step = -H gradient
//   secants.learn(step_taken, gradient_before, gradient_after);
//
// Cost: one solve with the factor and 4 n products a pair. One thread per object.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/mechanics/sparse/factor.h"

namespace tenter::mechanics {

class Secants {
 public:
  void forget(int unknowns);
  void solve(SparseFactor& factor, const Eigen::VectorXd& gradient, Eigen::VectorXd& step);
  /// `step` is what the unknowns moved by.
  void learn(const Eigen::VectorXd& step, const Eigen::VectorXd& before,
             const Eigen::VectorXd& after);

 private:
  static constexpr int kMost = 12;
  Eigen::MatrixXd steps_, changes_;  ///< columns s, y: a ring
  Eigen::VectorXd rest_;
  double per_work_[kMost] = {};  ///< r
  int count_ = 0, next_ = 0;
};

}  // namespace tenter::mechanics
