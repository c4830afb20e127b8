// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/secants.h"

#include <algorithm>

namespace tenter::mechanics {

void Secants::forget(int unknowns) {
  count_ = next_ = 0;
  steps_.resize(unknowns, kMost);
  changes_.resize(unknowns, kMost);
  rest_.resize(unknowns);
}

void Secants::solve(SparseFactor& factor, const Eigen::VectorXd& gradient, Eigen::VectorXd& step) {
  double shares[kMost];
  rest_ = gradient;
  const auto column = [this](int age) { return (next_ - 1 - age + 2 * kMost) % kMost; };
  for (int age = 0; age < count_; ++age) {
    const int k = column(age);
    shares[age] = per_work_[k] * steps_.col(k).dot(rest_);
    rest_ -= shares[age] * changes_.col(k);
  }
  step.resize(gradient.size());
  factor.solve(rest_.data(), step.data(), 1);
  for (int age = count_ - 1; age >= 0; --age) {
    const int k = column(age);
    step += (shares[age] - per_work_[k] * changes_.col(k).dot(step)) * steps_.col(k);
  }
  step = -step;
}

void Secants::learn(const Eigen::VectorXd& step, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after) {
  changes_.col(next_) = after - before;
  const double work = step.dot(changes_.col(next_));
  // of what this much curvature would give, rounding is a large part
  if (!(work > 1e-10 * step.norm() * changes_.col(next_).norm())) return;
  steps_.col(next_) = step;
  per_work_[next_] = 1.0 / work;
  next_ = (next_ + 1) % kMost;
  count_ = std::min(count_ + 1, kMost);
}

}  // namespace tenter::mechanics
