// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "server/mechanics/equilibrium/minimise.h"

namespace tenter::mechanics {
namespace {

constexpr double kSufficientDecrease = 1e-4;  // Armijo
constexpr double kNearRounding = 1e3;         // slopes of so many times that may be rounding too
constexpr double kForceDecrease = 0.5;        // of one step, where the energy is down to rounding
constexpr int kOldSteps = 3;                  // with an old factor, that have to be worth it:
constexpr double kFastDecrease = 0.3;         // of all of them together, the first alone
// How much of the negative stiffness is left out: less after every whole step, more where the step
// had to be shortened or the matrix was indefinite. Found by a search over ten cases of hanging
// cloth of 25 and 50 nodes a side; all near these do within a few per cent.
constexpr double kShareDecay = 0.5;
constexpr double kShareGrowth = 4.0;
constexpr double kShareIfShort = 0.2;
constexpr double kShareIfIndefinite = 0.25;
constexpr double kShareOfExact = 0.02;  // below it, none
constexpr double kShortStep = 0.4;      // of the first trial
constexpr int kMostShortSteps = 6;      // one after the other
constexpr double kAway = 100.0;         // extents: farther than this a mesh is not held

class Newton {
 public:
  Newton(const Potential& potential, SparseFactor& factor, const MinimiseOptions& options,
         State& state, MinimiseWorkspace& work)
      : potential_(potential), factor_(factor), options_(options), state_(state), work_(work) {}

  MinimiseResult run() {
    extent_ = extent_m(state_.x);
    max_move_ = options_.max_move_m > 0.0 ? options_.max_move_m : 0.1 * extent_;
    start_ = state_.x;
    share_ = options_.start_is_near ? options_.first_share : 1.0;
    work_.trial_state.clips.resize(state_.clips.size());
    if (!evaluate(state_, share_, work_.current)) return end(MinimiseEnd::start_not_finite);
    typical_N_m_ = typical_stiffness_N_m(potential_.unknowns.pattern(), work_.current);
    while (true) {
      if (work_.current.net_force_N <= options_.tolerance_N) return end(MinimiseEnd::converged);
      if (result_.iterations == options_.max_iterations) return end(MinimiseEnd::out_of_steps);
      ++result_.iterations;
      if (const auto stop = find_step()) return end(*stop);
      if (const auto stop = take_step()) return end(*stop);
      if (options_.learn_secants || (options_.reuse_factor && result_.has_exact_factor))
        step_again();
      if ((state_.x - start_).lpNorm<Eigen::Infinity>() > kAway * extent_)
        return end(MinimiseEnd::runs_away);
    }
  }

 private:
  bool evaluate(const State& at, double share, PotentialValue& value) {
    ++result_.evaluations;
    return potential_.evaluate_with_stiffness(at, share, value);
  }

  bool evaluate_forces(const State& at, PotentialValue& value) {
    ++result_.evaluations;
    return potential_.evaluate(at, value);
  }

  MinimiseResult end(MinimiseEnd how) {
    result_.end = how;
    result_.net_force_N = work_.current.net_force_N;
    return result_;
  }

  FactorStatus factorize(const std::vector<double>& values) {
    ++result_.factorisations;
    return factor_.factorize(values.data());
  }

  /// Factor and step for the current state. A value says why to stop.
  std::optional<MinimiseEnd> find_step() {
    if (!work_.current.has_stiffness && !evaluate(state_, share_, work_.current))
      return MinimiseEnd::no_descent;
    FactorStatus status = factorize(work_.current.stiffness);
    while (status == FactorStatus::not_positive_definite && share_ < 1.0) {
      share_ = std::clamp(kShareGrowth * share_, kShareIfIndefinite, 1.0);
      if (!evaluate(state_, share_, work_.current)) return MinimiseEnd::no_descent;
      status = factorize(work_.current.stiffness);
    }
    if (status == FactorStatus::not_positive_definite) status = factorize_shifted();
    if (status == FactorStatus::out_of_memory) return MinimiseEnd::out_of_memory;
    if (status != FactorStatus::ok) return MinimiseEnd::no_descent;
    result_.has_exact_factor = share_ == 0.0;
    result_.share = work_.current.positive_share;
    solve_for_step();
    return std::nullopt;
  }

  void solve_for_step() {
    work_.step.resize(potential_.unknowns.count());
    factor_.solve(work_.current.by_unknown.data(), work_.step.data(), 1);
    work_.step = -work_.step;
  }

  /// Steps with the factor that is there and what they learn on the way, while they are worth it.
  void step_again() {
    if (options_.learn_secants) work_.secants.forget(potential_.unknowns.count());
    while (true) {
      const double before_N = work_.current.net_force_N;
      for (int k = 0; k < (options_.learn_secants ? kOldSteps : 1); ++k)
        if (work_.current.net_force_N <= options_.tolerance_N || !take_old_step()) return;
      if (work_.current.net_force_N > kFastDecrease * before_N) return;
    }
  }

  /// False where it was not taken.
  bool take_old_step() {
    if (options_.learn_secants)
      work_.secants.solve(factor_, work_.current.by_unknown, work_.step);
    else
      solve_for_step();
    const double slope = work_.current.by_unknown.dot(work_.step);
    if (!(slope < 0.0) || potential_.unknowns.longest_move_m(work_.step) > max_move_) return false;
    potential_.unknowns.move(state_, work_.step, 1.0, work_.trial_state);
    if (potential_.longest_fraction(state_, work_.trial_state) < 1.0) return false;
    if (!evaluate_forces(work_.trial_state, work_.trial)) return false;
    const double share_left = work_.trial.net_force_N / work_.current.net_force_N;
    if (!options_.learn_secants) {
      if (share_left > kFastDecrease) return false;
    } else if (share_left > kForceDecrease && !is_better(work_.trial, slope)) {
      // once to the least of the parabola
      const double rise = work_.trial.energy_J - work_.current.energy_J - slope;
      const double fraction = std::clamp(-0.5 * slope / rise, 0.1, 0.7);
      work_.step *= fraction;
      potential_.unknowns.move(state_, work_.step, 1.0, work_.trial_state);
      if (!evaluate_forces(work_.trial_state, work_.trial) ||
          !is_better(work_.trial, fraction * slope))
        return false;
    }
    if (options_.learn_secants)
      work_.secants.learn(work_.step, work_.current.by_unknown, work_.trial.by_unknown);
    accept();
    return true;
  }

  /// The positive part may be singular (a free mesh, a slack spring): a small multiple of the
  /// identity makes it definite.
  FactorStatus factorize_shifted() {
    const SymmetricPattern& pattern = potential_.unknowns.pattern();
    double largest = 0.0;
    for (int j = 0; j < pattern.size; ++j)
      largest = std::max(largest, work_.current.stiffness[diagonal(pattern, j)]);
    if (largest == 0.0) largest = 1.0;
    FactorStatus status = FactorStatus::not_positive_definite;
    for (double shift = 1e-8 * largest;
         status == FactorStatus::not_positive_definite && shift <= 10.0 * largest; shift *= 10.0) {
      work_.shifted = work_.current.stiffness;
      for (int j = 0; j < pattern.size; ++j) work_.shifted[diagonal(pattern, j)] += shift;
      status = factorize(work_.shifted);
    }
    return status;
  }

  static std::size_t diagonal(const SymmetricPattern& pattern, int j) {
    return static_cast<std::size_t>(pattern.column_start[static_cast<std::size_t>(j)]);
  }

  /// Line search; the accepted point becomes the current one. A value says why to stop.
  std::optional<MinimiseEnd> take_step() {
    const double slope = work_.current.by_unknown.dot(work_.step);
    const double longest = potential_.unknowns.longest_move_m(work_.step);
    double first = longest <= max_move_ ? 1.0 : max_move_ / longest;
    const double share = share_;
    if (first == 1.0) share_ = share < kShareOfExact ? 0.0 : kShareDecay * share;
    potential_.unknowns.move(state_, work_.step, first, work_.trial_state);
    if (const double free = potential_.longest_fraction(state_, work_.trial_state); free < 1.0) {
      first *= free;
      potential_.unknowns.move(state_, work_.step, first, work_.trial_state);
    }
    // forces and stiffness at once: most first trials are taken
    const bool saves = options_.learn_secants || (options_.reuse_factor && share_ == 0.0);
    const bool is_finite = saves ? evaluate_forces(work_.trial_state, work_.trial)
                                 : evaluate(work_.trial_state, share_, work_.trial);
    if (is_finite && is_better(work_.trial, first * slope)) {
      short_steps_ = 0;
      accept();
      return std::nullopt;
    }
    if (drowns(slope)) return look_again(share);
    const auto fraction = search(first, slope, is_finite);
    if (!fraction)
      return drowns(slope / kNearRounding) ? look_again(share) : MinimiseEnd::no_descent;
    share_ = share_after(*fraction / first, share);
    potential_.unknowns.move(state_, work_.step, *fraction, work_.trial_state);
    if (!evaluate(work_.trial_state, share_, work_.trial)) return MinimiseEnd::no_descent;
    accept();
    return std::nullopt;
  }

  void accept() {
    std::swap(state_, work_.trial_state);
    std::swap(work_.current, work_.trial);
    if (work_.current.has_stiffness) return;
    // the stiffness is still that of the factor
    std::swap(work_.current.stiffness, work_.trial.stiffness);
    std::swap(work_.current.node_stiffness, work_.trial.node_stiffness);
  }

  /// A poor direction may look like rounding: once, the exact stiffness has the last word.
  std::optional<MinimiseEnd> look_again(double share) {
    if (share == 0.0 || has_looked_again_) return MinimiseEnd::at_rounding;
    has_looked_again_ = true;
    share_ = 0.0;
    if (!evaluate(state_, share_, work_.current)) return MinimiseEnd::no_descent;
    return std::nullopt;
  }

  /// The share after a step that had to be shortened to `part` of the first trial.
  double share_after(double part, double share) {
    if (part >= kShortStep) return share;
    if (++short_steps_ < kMostShortSteps)
      return std::clamp(kShareGrowth * share, kShareIfShort, 1.0);
    short_steps_ = 0;  // it is no help: what it leaves out may be what is missing
    return 0.0;
  }

  bool drowns(double slope) const {
    return is_rounding(work_.current, state_.x, typical_N_m_, slope);
  }

  bool is_better(const PotentialValue& trial, double predicted_J) const {
    const double noise_J = energy_noise_J(work_.current);
    const double change_J = trial.energy_J - work_.current.energy_J;
    if (-predicted_J > noise_J && change_J <= kSufficientDecrease * predicted_J) return true;
    // energies tell nothing any more, forces do a little longer
    return std::abs(change_J) <= noise_J &&
           trial.net_force_N <= kForceDecrease * work_.current.net_force_N;
  }

  /// Smaller fractions by safeguarded quadratic interpolation.
  std::optional<double> search(double fraction, double slope, bool is_finite) {
    const double smallest = 1e-12 * fraction;
    double energy = is_finite ? work_.trial.energy_J : std::numeric_limits<double>::infinity();
    while (fraction > smallest && -fraction * slope > energy_noise_J(work_.current)) {
      const double rise = energy - work_.current.energy_J - fraction * slope;
      const double best = -0.5 * slope * fraction * fraction / rise;
      fraction =
          std::isfinite(best) ? std::clamp(best, 0.1 * fraction, 0.5 * fraction) : 0.25 * fraction;
      potential_.unknowns.move(state_, work_.step, fraction, work_.trial_state);
      ++result_.evaluations;
      energy = potential_.energy_J(work_.trial_state);
      if (energy <= work_.current.energy_J + kSufficientDecrease * fraction * slope)
        return fraction;
    }
    return std::nullopt;
  }

  const Potential& potential_;
  SparseFactor& factor_;
  const MinimiseOptions& options_;
  State& state_;
  MinimiseWorkspace& work_;
  MinimiseResult result_;
  Eigen::VectorXd start_;
  double extent_ = 0.0;
  double max_move_ = 0.0;
  double typical_N_m_ = 0.0;  ///< stiffness at the start
  int short_steps_ = 0;
  bool has_looked_again_ = false;
  double share_ = 1.0;  ///< positive share of the stiffness, see ModelOutput
};

}  // namespace

MinimiseResult minimise_by_newton(const Potential& potential, SparseFactor& factor,
                                  const MinimiseOptions& options, State& state,
                                  MinimiseWorkspace& work) {
  return Newton(potential, factor, options, state, work).run();
}

}  // namespace tenter::mechanics
