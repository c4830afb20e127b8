// SPDX-License-Identifier: GPL-3.0-or-later
// One implicit time step of a mesh: the least incremental potential (time_scheme.h) under given
// loads, clips and obstacles at the end of the step.
//
//   auto stepper = TimeStepper::make(model, boundary, obstacles);
//   Motion motion = at_rest(boundary, state);
//   StepInput input{0.01, loads};
//   auto step = stepper->step(parameters, input, motion, options);
//   if (!step) ...                                    // what was passed does not fit together
//   if (!step->is_good(options)) ...                  // not solved: the motion is unchanged
//
// Energy limits and contact hold at the end of every step, with multipliers that start from those
// of the last one (thesis 4.3.2 has Lagrange multipliers in an LCP; the conditions are the same).
// Laws that remember their path (friction) answer with the incremental potential of the step, those
// of the strain's rate with the rate that the scheme has at its end: Baraff-Witkin damping is a
// kelvin_voigt term for every strain (damping.h).
// Friction's tangent jumps where a strain turns round, and at a guess strains are off by many times
// what they change by in a step: Newton would start with every element turned. So the solve first
// takes one step of friction linearised at the strains that go on as they went (history.h, ahead);
// after each factorisation it goes on with what its steps learn (equilibrium/secants.h). How much
// negative stiffness has to be left out is remembered from step to step.
// Masses are those of the loads: what hangs at a node has inertia too.
//
// A linearised step (Baraff and Witkin 1998) solves (M/h^2 + K(x0)) dx = f(x0) + M v^/h once, for
// comparison: its net force is that of its result, whatever it is.
//
// A stepper keeps pattern, factor and scratch; it belongs to one thread at a time. Its result
// depends on what is passed and on its steps before. After the first step nothing allocates but for
// what obstacles and limits take.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "server/mechanics/dynamics/step_energy.h"
#include "server/mechanics/equilibrium/constraint_rounds.h"
#include "server/mechanics/equilibrium/minimise.h"

namespace tenter::mechanics {

struct StepInput {
  double duration_s = 0.0;
  Loads loads;                      ///< at the end of the step; masses are needed
  std::vector<Pose> clips;          ///< of prescribed clips at the end; empty: they stay
  std::vector<Obstacle> obstacles;  ///< at the end, as many as made; empty: they stay
};

struct StepOptions {
  TimeScheme scheme = TimeScheme::bdf2;
  double tolerance_N = 1e-5;  ///< net force, inertia included
  int max_iterations = 200;
  bool is_linearised = false;
  double contact_depth_m = 1e-6;
  double limit_tolerance = 1e-6;     ///< energy limits hold to this part of psi_max
  double contact_penalty_N_m = 0.0;  ///< 0: the mean of the stiffness' diagonal
  double largest_error_m = 0.0;      ///< a step of a larger estimate is not good; 0: any
};

struct StepResult {
  MinimiseResult last;  ///< the last minimisation
  int iterations = 0;   ///< of all minimisations
  int factorisations = 0;
  int evaluations = 0;
  double error_m = 0.0;  ///< estimate for this step: root mean square over the mass
  int order = 1;         ///< the error goes with the power order + 1 of the duration
  double work_J = 0.0;   ///< done by who moves the prescribed clips
  Violation violation;

  /// A linearised step counts as solved where its system has a solution.
  bool is_solved(const StepOptions& options) const {
    return last.is_equilibrium() &&
           violation.is_within({options.contact_depth_m, options.limit_tolerance});
  }
  bool is_good(const StepOptions& options) const {
    return is_solved(options) &&
           (options.largest_error_m == 0.0 || error_m <= options.largest_error_m);
  }
};
std::string describe(const StepResult& result, const StepOptions& options);

class TimeStepper {
 public:
  /// `model` must outlive the stepper. bad_input as check() of boundary and obstacles, and where
  /// nothing is free.
  static Expected<TimeStepper> make(const MeshModel& model, Boundary boundary,
                                    std::vector<Obstacle> obstacles = {});

  /// bad_input where sizes do not fit, a number is none, masses are missing, or a duration is not
  /// positive. `motion` goes to the end of the step where the result is good.
  Expected<StepResult> step(const Eigen::VectorXd& parameters, const StepInput& input,
                            Motion& motion, const StepOptions& options = {});

  /// From now on the sheet does not pass through itself (contact/self_contact.h). Steps in which
  /// what is prescribed would make it are not good; linearised ones are refused.
  void keep_apart(SelfContact contact) { added_.self_contact = std::move(contact); }

  const MeshModel& model() const { return *model_; }
  const Boundary& boundary() const { return boundary_; }
  const Unknowns& unknowns() const { return *unknowns_; }
  /// Slope of the last step's incremental potential over all nodes, N: what holders feel.
  const Eigen::VectorXd& by_node() const { return work_.current.by_node; }
  /// Force between obstacles and nodes after the last step: [obstacle * free nodes + free node].
  Eigen::VectorXd contact_force_N(const State& state) const {
    return rounds_.contact().acting_forces_N(state.x);
  }

 private:
  TimeStepper() = default;
  Expected<void> check_input(const Eigen::VectorXd& parameters, const StepInput& input,
                             const Motion& motion, const StepOptions& options) const;
  /// False where the material's memory of the start is no number.
  bool start_history(const Eigen::VectorXd& parameters, double duration_s, Motion& motion);
  void start_constraints(const Potential& potential, const StepInput& input,
                         const StepOptions& options);
  void solve(const Potential& potential, const StepOptions& options, StepResult& result);
  /// From end_ to the trial state where that costs less and nothing is in the way.
  bool take_if_lower(const Potential& potential, double& energy_J);
  /// From end_, whose energy is given, one step of what the history linearises ahead.
  void look_ahead(const Potential& potential, double energy_J, StepResult& result);
  MinimiseEnd solve_linearised(const Potential& potential, const State& start, StepResult& result);
  void report(const Potential& potential, const Motion& motion, StepResult& result);

  const MeshModel* model_ = nullptr;
  Boundary boundary_;
  std::vector<Obstacle> obstacles_;
  std::shared_ptr<const Unknowns> unknowns_;
  std::unique_ptr<SparseFactor> factor_;
  ConstraintRounds rounds_;
  bool has_rounds_ = false;
  double penalty_N_m_ = 0.0;  ///< of contact, at the start of every step
  StepStart start_;
  StepEnergy added_;
  MinimiseWorkspace work_;
  History history_;        ///< of the step that is being solved
  bool has_path_ = false;  ///< history_.ahead is there
  /// Of negative stiffness left out at first: looking ahead, by Newton, in a linearised step.
  double ahead_share_ = 0.0, first_share_ = 0.0, linear_share_ = 0.0;
  State end_;  ///< of the step that is being solved
  Eigen::VectorXd points_;
};

}  // namespace tenter::mechanics
