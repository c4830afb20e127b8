// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/equilibrium/minimise.h"

#include <algorithm>
#include <cmath>
#include <vector>

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
      return "no step lowers the energy: it is not smooth there, as where an element collapses";
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

double typical_stiffness_N_m(const SymmetricPattern& pattern, const PotentialValue& value) {
  std::vector<double> diagonal(static_cast<std::size_t>(pattern.size));
  for (std::size_t j = 0; j < diagonal.size(); ++j)
    diagonal[j] = std::abs(value.stiffness[static_cast<std::size_t>(pattern.column_start[j])]);
  const auto upper = diagonal.begin() + 3 * (pattern.size / 4);
  std::nth_element(diagonal.begin(), upper, diagonal.end());
  return *upper;
}

bool is_rounding(const PotentialValue& value, const Eigen::VectorXd& x, double typical_N_m,
                 double slope_J) {
  constexpr double kRounding = 4e-15;
  constexpr double kPlenty = 1e4;  // stiffness grows on the way, too
  const double force_noise_N = kRounding * typical_N_m *
                               std::sqrt(static_cast<double>(value.by_unknown.size())) *
                               x.lpNorm<Eigen::Infinity>();
  return value.net_force_N <= force_noise_N ||
         (-slope_J <= energy_noise_J(value) &&
          value.net_force_N * value.net_force_N <= kPlenty * typical_N_m * energy_noise_J(value));
}

}  // namespace tenter::mechanics
