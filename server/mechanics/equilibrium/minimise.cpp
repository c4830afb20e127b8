// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/minimise.h"

#include <cmath>

namespace tenter::mechanics {

std::string describe(MinimiseEnd end) {
  switch (end) {
    case MinimiseEnd::converged:
      return "the net force is below the tolerance";
    case MinimiseEnd::at_rounding:
      return "the net force is down to rounding";
    case MinimiseEnd::out_of_steps:
      return "the limit of iterations was reached";
    case MinimiseEnd::no_descent:
      return "no step lowers the energy";
    case MinimiseEnd::start_not_finite:
      return "energy or force is no number at the start: an element has collapsed or is inverted";
    case MinimiseEnd::runs_away:
      return "the mesh leaves its surroundings: nothing holds it, or it collapses";
    case MinimiseEnd::out_of_memory:
      return "the factorisation does not fit into memory";
  }
  return {};
}

double extent_m(const Eigen::VectorXd& x) {
  if (x.size() == 0) return 0.0;
  const Eigen::Map<const Eigen::Matrix3Xd> nodes(x.data(), 3, x.size() / 3);
  return (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
}

double energy_noise_J(const PotentialValue& value) {
  constexpr double kRounding = 1e-14;
  return kRounding * value.energy_size_J;
}

double force_noise_N(const SymmetricPattern& pattern, const PotentialValue& value,
                     const Eigen::VectorXd& x) {
  constexpr double kRounding = 1e-15;
  double squared = 0.0;
  for (int j = 0; j < pattern.size; ++j) {
    const double k =
        value
            .stiffness[static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j)])];
    squared += k * k;
  }
  return kRounding * std::sqrt(squared) * x.lpNorm<Eigen::Infinity>();
}

}  // namespace tenter::mechanics
