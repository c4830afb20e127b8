// SPDX-License-Identifier: GPL-3.0-or-later
// Static equilibrium of a mesh: the state of least potential energy under given boundary and loads.
//
//   auto solver = EquilibriumSolver::make(model, boundary);
//   State state{x, poses};              // start, with held nodes and poses where they shall be
//   auto result = solver->solve(parameters, loads, state, options);    // state: the equilibrium
//   if (!result) ...                                       // what was passed does not fit together
//   if (!result->is_good(options)) log(describe(*result, options));    // how it ended otherwise
//
// Frame after frame: move the held nodes and prescribed poses of the last result (or change the
// parameters) and solve again with start_is_near. A solver that still has the factor of that result
// predicts the new state from it.
//
// Where laws remember their path, a History is passed along (assembly/history/): the result is the
// equilibrium at the end of the step that starts there, and the caller takes the history to its
// end.
//
// A solver keeps pattern, factor and scratch; it belongs to one thread at a time. Its result
// depends on what is passed and on the solve before, never on another solver: frames of several
// sequences may be solved in several threads with the same bytes as in one.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "server/mechanics/equilibrium/constraint_rounds.h"
#include "server/mechanics/equilibrium/minimise.h"

namespace tenter::mechanics {

enum class Minimiser { newton, additive_lm, relaxation };

struct EquilibriumOptions {
  double tolerance_N = 1e-5;  ///< thesis 3.4.1; 0: to rounding
  int max_iterations = 2000;
  bool start_is_near = false;
  bool predict = true;  ///< where the start is the last result and near; off, a solve depends on
                        ///< nothing but what is passed
  double max_move_m = 0.0;  ///< see MinimiseOptions
  Minimiser minimiser = Minimiser::newton;
  bool check_minimum = true;  ///< and leave saddles
  /// Newton: fewer factorisations near a solution. Where a factor of an exact, positive definite
  /// stiffness on the last way to the result is at hand, it stands for the check of the minimum,
  /// and factor() and node_stiffness() are there: sensitivities are then off by what the stiffness
  /// changed on that way, which shrinks with it.
  bool reuse_factor = false;
  double contact_depth_m = 1e-6;     ///< conditions of contact hold to this
  double limit_tolerance = 1e-6;     ///< energy limits hold to this part of psi_max
  double contact_penalty_N_m = 0.0;  ///< 0: the mean of the stiffness' diagonal
};

enum class Stability {
  minimum,  ///< stiffness positive definite: stable
  neutral,  ///< a motion costs no energy, to rounding or to the net force that is left
  saddle,   ///< a motion lowers the energy, and the state could not be left
  not_checked
};

struct EquilibriumResult {
  MinimiseResult last;     ///< the last minimisation
  int iterations = 0;      ///< of all minimisations
  int factorisations = 0;  ///< with those of the check
  int evaluations = 0;
  int saddles_left = 0;
  double energy_J = 0.0;  ///< infinite, with no by_node, where the start had no energy
  Stability stability = Stability::not_checked;
  double contact_violation_m = 0.0;
  double limit_violation = 0.0;      ///< of energy limits, in parts of psi_max
  Eigen::VectorXd limit_multiplier;  ///< one an entry of MeshModel::limited()
  Eigen::VectorXd contact_force_N;   ///< [obstacle * free nodes + free node]
  Eigen::VectorXd by_node;           ///< dPi/dx, N: zero at free nodes; reaction() sums it

  /// In equilibrium, stable where that was checked, outside of obstacles and within energy limits.
  bool is_good(const EquilibriumOptions& options) const {
    return last.is_equilibrium() && stability != Stability::saddle &&
           contact_violation_m <= options.contact_depth_m &&
           limit_violation <= options.limit_tolerance;
  }
};
std::string describe(const EquilibriumResult& result, const EquilibriumOptions& options);

class EquilibriumSolver {
 public:
  /// `model` must outlive the solver. bad_input as check() of boundary and obstacles, and for a
  /// pressed surface whose edges are none of the mesh, and where nothing is free.
  static Expected<EquilibriumSolver> make(const MeshModel& model, Boundary boundary,
                                          std::vector<Obstacle> obstacles = {});

  const Boundary& boundary() const { return boundary_; }
  const Unknowns& unknowns() const { return *unknowns_; }

  /// bad_input where sizes do not fit, a number is none, a pose no rotation or an option out of its
  /// range. `state`: start, and result. `history` is read again by sensitivities of the result.
  Expected<EquilibriumResult> solve(const Eigen::VectorXd& parameters, const Loads& loads,
                                    State& state, const EquilibriumOptions& options = {},
                                    const History* history = nullptr);

  const MeshModel& model() const { return *model_; }
  const Contact& contact() const { return rounds_.contact(); }
  const EnergyLimitState& limits() const { return rounds_.limits(); }
  /// Of the last solve; null: none.
  const History* history() const { return history_; }
  /// The factor of the exact stiffness at the last result (near it with reuse_factor); null unless
  /// that was checked to be a minimum.
  SparseFactor* factor() { return has_factor_ ? factor_.get() : nullptr; }
  /// Stiffness over all nodes there, loads and contact included.
  const NodeMatrix& node_stiffness() const { return work_.current.node_stiffness; }

 private:
  EquilibriumSolver() = default;
  MinimiseResult minimise(const Potential& potential, const EquilibriumOptions& options,
                          bool is_near, State& state);
  void predict(const Potential& potential, State& state);
  Stability check(const Potential& potential, const State& state, EquilibriumResult& result);
  bool has_soft_motion(const State& state);
  bool leave_saddle(const Potential& potential, State& state);
  void start_constraints(const Potential& potential, const EquilibriumOptions& options,
                         const State& state);
  Expected<void> check_input(const Eigen::VectorXd& parameters, const Loads& loads,
                             const State& state, const History* history) const;

  const MeshModel* model_ = nullptr;
  Boundary boundary_;
  std::vector<Obstacle> obstacles_;
  std::shared_ptr<const Unknowns> unknowns_;
  std::unique_ptr<SparseFactor> factor_;
  ConstraintRounds rounds_;
  const History* history_ = nullptr;
  MinimiseWorkspace work_;
  bool has_factor_ = false;
  bool can_predict_ = false;     ///< the factor is near enough to the last result for a prediction
  State solved_;                 ///< last result, of which factor and stiffness are
  Eigen::VectorXd lowest_mode_;  ///< direction of least stiffness of a saddle
};

}  // namespace tenter::mechanics
