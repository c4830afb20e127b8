// SPDX-License-Identifier: GPL-3.0-or-later
// Ways to a state without net force, on one potential energy: what they share, and their names.
//
//   MinimiseResult result = minimise_by_newton(potential, factor, options, state, workspace);
//
// Newton and additive LM lower the real energy or, once that drowns in rounding, the net force, so
// `state` is the best one found, whatever the end; relaxation swings about the minimum.
// Deterministic; one thread per workspace and factor.
#pragma once

#include <string>

#include "server/mechanics/conditions/potential.h"
#include "server/mechanics/equilibrium/secants.h"
#include "server/mechanics/sparse/factor.h"

namespace tenter::mechanics {

enum class MinimiseEnd {
  converged,         ///< net force at or below the tolerance
  at_rounding,       ///< no step changes energy or net force beyond rounding any more
  out_of_steps,      ///< max_iterations reached
  no_descent,        ///< no step along a descent direction lowered the energy
  start_not_finite,  ///< energy or force is no number at the start
  runs_away,         ///< a node left the surroundings: nothing holds the mesh, or it collapses
  out_of_memory      ///< the factorisation does not fit
};

/// One sentence a user can act on.
std::string describe(MinimiseEnd end);

struct MinimiseOptions {
  double tolerance_N = 1e-5;  ///< thesis 3.4.1; 0: to rounding
  int max_iterations = 2000;
  bool start_is_near = false;  ///< trust the exact stiffness from the start
  double max_move_m = 0.0;     ///< longest way of a node in one step; 0: a tenth of the extent
  /// Newton: with the factor of the last exact stiffness go on while steps shrink the net force
  /// fast; then the stiffness that is kept is that of the factor, not of the end.
  bool reuse_factor = false;
  /// The same with any factor and with what steps learn on the way (secants.h): farther, so that
  /// the factor says little of the end.
  bool learn_secants = false;
  double first_share = 0.0;  ///< where start_is_near: of negative stiffness left out at first
};

struct MinimiseResult {
  MinimiseEnd end = MinimiseEnd::converged;
  int iterations = 0;
  int factorisations = 0;
  int evaluations = 0;  ///< of the energy, with or without derivatives
  double net_force_N = 0.0;
  bool has_exact_factor = false;  ///< the factor is that of an exact stiffness near the end
  double share = 0.0;             ///< of negative stiffness left out of the last factor

  bool is_equilibrium() const {
    return end == MinimiseEnd::converged || end == MinimiseEnd::at_rounding;
  }
};

/// Scratch that is kept between solves. `current` belongs to the returned state.
struct MinimiseWorkspace {
  PotentialValue current, trial;
  State trial_state;
  Eigen::VectorXd step, sum;
  std::vector<double> shifted;
  Secants secants;
};

/// Largest distance of two corners of the box around all nodes (m).
double extent_m(const Eigen::VectorXd& x);

/// What rounding may change of an energy (J).
double energy_noise_J(const PotentialValue& value);
/// Three quarters of the unknowns are no stiffer than this.
double typical_stiffness_N_m(const SymmetricPattern& pattern, const PotentialValue& value);
/// Whether a step with this slope (J) can change nothing but rounding: of the energy, or of the
/// forces, which positions make by being rounded. `typical_N_m` is that of the start: where an
/// element collapses on the way, its forces are large and its own stiffness says nothing of them.
bool is_rounding(const PotentialValue& value, const Eigen::VectorXd& x, double typical_N_m,
                 double slope_J);

/// Newton's method with a line search on the energy. Far from a minimum a share of the elements'
/// negative stiffness is left out, so that steps are neither uphill nor too long for what the
/// quadratic model knows; near one the stiffness is exact.
MinimiseResult minimise_by_newton(const Potential& potential, SparseFactor& factor,
                                  const MinimiseOptions& options, State& state,
                                  MinimiseWorkspace& work);

/// Thesis 3.4.1, for comparison: exact stiffness + mu I, with mu raised where the energy does not
/// fall and lowered where it does.
MinimiseResult minimise_by_additive_lm(const Potential& potential, SparseFactor& factor,
                                       const MinimiseOptions& options, State& state,
                                       MinimiseWorkspace& work);

/// Thesis 4.3.2, for comparison: damped dynamics in fictitious time, all velocities set to zero
/// whenever the kinetic energy has passed a peak. Masses follow the stiffness' diagonal.
MinimiseResult minimise_by_relaxation(const Potential& potential, const MinimiseOptions& options,
                                      State& state, MinimiseWorkspace& work);

}  // namespace tenter::mechanics
