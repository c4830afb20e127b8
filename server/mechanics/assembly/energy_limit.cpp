// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/assembly/energy_limit.h"

#include <algorithm>
#include <cmath>

namespace tenter::mechanics {

double update_multipliers(const Eigen::VectorXd& excess, EnergyLimitState& state) {
  double largest = 0.0;
  for (Eigen::Index k = 0; k < excess.size(); ++k) {
    const double next = std::max(0.0, state.multiplier[k] + state.penalty * excess[k]);
    largest = std::max(largest, std::abs(next - state.multiplier[k]));
    state.multiplier[k] = next;
  }
  return largest;
}

}  // namespace tenter::mechanics
