// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "server/mechanics/equilibrium/minimise.h"

namespace tenter::mechanics {
namespace {

/// Fictitious masses at which a unit time step is stable: the row sums of the positive stiffness
/// bound its largest eigenvalue (Gershgorin).
void take_masses(const SymmetricPattern& pattern, const std::vector<double>& values,
                 Eigen::VectorXd& mass) {
  mass.setZero(pattern.size);
  for (int j = 0; j < pattern.size; ++j) {
    for (int k = pattern.column_start[static_cast<std::size_t>(j)];
         k < pattern.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
      const int i = pattern.row[static_cast<std::size_t>(k)];
      const double size = std::abs(values[static_cast<std::size_t>(k)]);
      mass[j] += size;
      if (i != j) mass[i] += size;
    }
  }
  const double least = 1e-6 * std::max(mass.maxCoeff(), 1e-300);
  mass = mass.cwiseMax(least);
}

}  // namespace

MinimiseResult minimise_by_relaxation(const Potential& potential, const MinimiseOptions& options,
                                      State& state, MinimiseWorkspace& work) {
  MinimiseResult result;
  const auto end = [&](MinimiseEnd how) {
    result.end = how;
    result.net_force_N = work.current.net_force_N;
    return result;
  };
  const double extent = extent_m(state.x);
  const double max_move = options.max_move_m > 0.0 ? options.max_move_m : 0.1 * extent;
  const Eigen::VectorXd start = state.x;
  constexpr int kStepsPerMass = 50;  // the stiffness grows with the strain, slowly
  Eigen::VectorXd mass;
  Eigen::VectorXd velocity = Eigen::VectorXd::Zero(potential.unknowns.count());
  double kinetic = 0.0;
  double safety = 1.0;
  constexpr double kSlowest = 1e6;
  work.trial_state.clips.resize(state.clips.size());
  while (true) {
    const bool renews_mass = result.iterations % kStepsPerMass == 0;
    ++result.evaluations;
    if (!(renews_mass ? potential.evaluate_with_stiffness(state, 1.0, work.current)
                      : potential.evaluate(state, work.current))) {
      if (result.iterations == 0) return end(MinimiseEnd::start_not_finite);
      // back to where it was a number, and more slowly
      std::swap(state, work.trial_state);
      if (!potential.evaluate(state, work.current) || safety >= kSlowest)
        return end(MinimiseEnd::no_descent);
      safety *= 4.0;
      velocity.setZero();
      kinetic = 0.0;
    } else if (renews_mass) {
      take_masses(potential.unknowns.pattern(), work.current.stiffness, mass);
    }
    if ((state.x - start).lpNorm<Eigen::Infinity>() > 100.0 * extent)
      return end(MinimiseEnd::runs_away);
    if (work.current.net_force_N <= options.tolerance_N) return end(MinimiseEnd::converged);
    if (result.iterations == options.max_iterations) return end(MinimiseEnd::out_of_steps);
    ++result.iterations;
    velocity -= work.current.by_unknown.cwiseQuotient(safety * mass);
    const double now = velocity.cwiseProduct(mass).dot(velocity);
    if (now < kinetic) {
      velocity.setZero();
      kinetic = 0.0;
      continue;
    }
    kinetic = now;
    const double longest = potential.unknowns.longest_move_m(velocity);
    if (longest > max_move) {
      velocity *= max_move / longest;
      if (safety < 16.0) safety *= 2.0;
    }
    potential.unknowns.move(state, velocity, 1.0, work.trial_state);
    std::swap(state, work.trial_state);
  }
}

}  // namespace tenter::mechanics
