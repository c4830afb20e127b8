// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/lowest_mode.h"

#include <cmath>

namespace tenter::mechanics {

void spread_start(int size, Eigen::VectorXd& direction) {
  direction.resize(size);
  for (int j = 0; j < size; ++j)  // the golden ratio's multiples never repeat
    direction[j] = std::fmod(0.618033988749895 * j, 1.0) - 0.5;
  direction.normalize();
}

LowestMode lowest_mode(const SymmetricPattern& pattern, const std::vector<double>& values,
                       SparseFactor& factor) {
  LowestMode mode;
  const auto diagonal = [&pattern](int j) {
    return static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j)]);
  };
  for (int j = 0; j < pattern.size; ++j)
    mode.largest_diagonal = std::max(mode.largest_diagonal, std::abs(values[diagonal(j)]));
  std::vector<double> shifted;
  for (double shift = 1e-12 * mode.largest_diagonal; shift < 10.0 * mode.largest_diagonal;
       shift *= 10.0) {
    shifted = values;
    for (int j = 0; j < pattern.size; ++j) shifted[diagonal(j)] += shift;
    if (factor.factorize(shifted.data()) == FactorStatus::ok) break;
  }
  spread_start(pattern.size, mode.direction);
  constexpr int kSteps = 30;
  for (int step = 0; step < kSteps; ++step) {
    mode.direction.normalize();
    factor.solve(mode.direction.data(), mode.direction.data(), 1);
  }
  mode.direction.normalize();
  Eigen::VectorXd product(pattern.size);
  multiply(pattern, values.data(), mode.direction.data(), product.data());
  mode.stiffness = mode.direction.dot(product);
  return mode;
}

}  // namespace tenter::mechanics
