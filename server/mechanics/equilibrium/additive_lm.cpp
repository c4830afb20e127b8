// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <utility>

#include "server/mechanics/equilibrium/minimise.h"

namespace tenter::mechanics {

MinimiseResult minimise_by_additive_lm(const Potential& potential, SparseFactor& factor,
                                       const MinimiseOptions& options, State& state,
                                       MinimiseWorkspace& work) {
  MinimiseResult result;
  const SymmetricPattern& pattern = potential.unknowns.pattern();
  const auto diagonal = [&pattern](int j) {
    return static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j)]);
  };
  const auto end = [&](MinimiseEnd how) {
    result.end = how;
    result.net_force_N = work.current.net_force_N;
    return result;
  };
  const double extent = extent_m(state.x);
  const double max_move = options.max_move_m > 0.0 ? options.max_move_m : 0.1 * extent;
  const Eigen::VectorXd start = state.x;
  work.trial_state.clips.resize(state.clips.size());
  ++result.evaluations;
  if (!potential.evaluate_with_stiffness(state, 0.0, work.current))
    return end(MinimiseEnd::start_not_finite);
  double largest = 0.0;
  for (int j = 0; j < pattern.size; ++j)
    largest = std::max(largest, std::abs(work.current.stiffness[diagonal(j)]));
  if (largest == 0.0) largest = 1.0;
  constexpr double kSmallest = 1e-14, kLargest = 1e10;  // mu, of the stiffness
  const double typical_N_m = typical_stiffness_N_m(pattern, work.current);
  double mu = 1e-3 * largest;

  while (true) {
    if (work.current.net_force_N <= options.tolerance_N) return end(MinimiseEnd::converged);
    if (result.iterations == options.max_iterations) return end(MinimiseEnd::out_of_steps);
    ++result.iterations;
    work.shifted = work.current.stiffness;
    for (int j = 0; j < pattern.size; ++j) work.shifted[diagonal(j)] += mu;
    ++result.factorisations;
    const FactorStatus status = factor.factorize(work.shifted.data());
    if (status == FactorStatus::out_of_memory) return end(MinimiseEnd::out_of_memory);
    bool is_accepted = false;
    double slope = 0.0;
    if (status == FactorStatus::ok) {
      work.step.resize(pattern.size);
      factor.solve(work.current.by_unknown.data(), work.step.data(), 1);
      work.step = -work.step;
      slope = work.current.by_unknown.dot(work.step);
      if (potential.unknowns.longest_move_m(work.step) <= max_move) {
        potential.unknowns.move(state, work.step, 1.0, work.trial_state);
        ++result.evaluations;
        const double noise = energy_noise_J(work.current);
        const double change = potential.evaluate_with_stiffness(work.trial_state, 0.0, work.trial)
                                  ? work.trial.energy_J - work.current.energy_J
                                  : 1.0;
        is_accepted = change < -noise || (std::abs(change) <= noise &&
                                          work.trial.net_force_N < work.current.net_force_N);
        if (!is_accepted && is_rounding(work.current, state.x, typical_N_m, slope))
          return end(MinimiseEnd::at_rounding);
      }
    }
    if (is_accepted) {
      std::swap(state, work.trial_state);
      std::swap(work.current, work.trial);
      mu = std::max(mu / 3.0, kSmallest * largest);
      if ((state.x - start).lpNorm<Eigen::Infinity>() > 100.0 * extent)
        return end(MinimiseEnd::runs_away);
    } else {
      mu *= 4.0;
      if (mu > kLargest * largest) return end(MinimiseEnd::no_descent);
    }
  }
}

}  // namespace tenter::mechanics
