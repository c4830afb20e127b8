// SPDX-License-Identifier: GPL-3.0-or-later
// How SequenceEvaluator brings frames to rest: alone, or one after the other.
#include <algorithm>
#include <utility>

#include "server/estimation/sequences/sequence_work.h"

namespace tenter::estimation {

using mechanics::EquilibriumOptions;
using mechanics::EquilibriumSolver;
using mechanics::State;

namespace {

/// Prescribed clips where they were measured: what slipped out of them moved, they did not.
void put_back(const Sequence& sequence, std::size_t frame,
              const std::vector<mechanics::Pose>& clips, State& state) {
  const auto boundary = static_cast<std::size_t>(sequence.frames[frame].boundary);
  for (std::size_t c = 0; c < clips.size(); ++c)
    if (!sequence.boundaries[boundary].clips[c].is_free) state.clips[c] = clips[c];
}

}  // namespace

EquilibriumSolver& SequenceEvaluator::solver_of(int thread, std::size_t sequence,
                                                std::size_t frame) {
  const Sequence& of = sequences_[sequence];
  const auto boundary = static_cast<std::size_t>(of.frames[frame].boundary);
  auto& solver = solvers_[static_cast<std::size_t>(thread)][sequence][boundary];
  if (!solver)
    solver = std::make_unique<EquilibriumSolver>(
        EquilibriumSolver::make(bound_[sequence]->model, of.boundaries[boundary]).value());
  return *solver;
}

/// The frames of a run one after the other, each from the one before.
void SequenceEvaluator::walk(const Run& run, int thread, const Eigen::VectorXd& parameters,
                             Derivative wanted) {
  const Sequence& sequence = sequences_[run.sequence];
  const auto& start = sequence.frames[run.first].start;
  const State* before = start ? &*start : &sequence.start;
  for (std::size_t f = run.first; f <= run.last; ++f) {
    State& state = frames_[run.sequence][f]->slots[last_].state;
    state = *before;
    before = &state;
    const bool is_next = f > run.first;
    const bool is_near = is_next || (start && options_.starts_are_near);
    if (!solve_frame(run.sequence, f, thread, parameters, {is_near, is_next, wanted})) return;
  }
}

bool SequenceEvaluator::solve_frame(std::size_t sequence, std::size_t frame, int thread,
                                    const Eigen::VectorXd& parameters, const SolveHow& how) {
  EquilibriumSolver& solver = solver_of(thread, sequence, frame);
  const Sequence& measured = sequences_[sequence];
  FrameWork& work = *frames_[sequence][frame];
  FrameWork::Slot& slot = work.slots[last_];
  if (options_.on_frame) options_.on_frame({measured, static_cast<int>(frame), parameters});
  mechanics::Loads loads = measured.loads;
  loads.cord_force_N = measured.frames[frame].cord_force_N;
  prescribe(measured, frame, !how.is_near, slot.state);
  const std::vector<mechanics::Pose> clips = slot.state.clips;
  sensors_.act(measured, sequence, frame, parameters, loads, slot.state.clips);
  EquilibriumOptions options;
  options.tolerance_N = options_.tolerance_N;
  if (accuracy_ == Accuracy::stepping) {
    options.tolerance_N = std::max(options.tolerance_N, options_.stepping_tolerance_N);
    // tangents of friction jump where a strain turns: an old factor says nothing of the new state
    options.reuse_factor = !remembers_;
    if (how.gives_up) options.max_iterations = options_.stepping_max_iterations;
  }
  options.start_is_near = how.is_near;
  options.check_minimum = how.wanted != Derivative::none;
  options.predict = how.may_predict;
  const auto now = [this] { return options_.clock ? options_.clock() : 0.0; };
  const double began = now();
  auto solved = solver.solve(term_parameters_, loads, slot.state, options, how.history);
  put_back(measured, frame, clips, slot.state);
  const double rested = now();
  ++work.cost.equilibria;
  work.cost.equilibrium_s += rested - began;
  if (solved) {
    work.cost.iterations += solved->iterations;
    work.cost.factorisations += solved->factorisations;
    work.cost.evaluations += solved->evaluations;
  }
  if (!solved || !solved->is_good(options)) {
    work.failure = solved ? describe(*solved, options) : solved.error().message;
    return false;
  }
  slot.by_node = std::move(solved->by_node);
  if (how.wanted == Derivative::none) return true;
  const auto change = differentiate(sequence, frame, solver, parameters, how.wanted);
  work.cost.sensitivity_s += now() - rested;
  ++work.cost.sensitivities;
  if (!change) work.failure = change.error().message;
  return change.has_value();
}

/// Where the last Jacobian was taken, moved by dx/dp; the last evaluation, where parameters are its
/// own.
void SequenceEvaluator::start_from(const FrameWork& work, int from,
                                   const std::vector<Eigen::Index>& columns,
                                   const Eigen::VectorXd& parameters, State& state) const {
  if (from != last_) state = work.slots[from].state;
  if (from != base_ || parameters == base_parameters_) return;
  const Eigen::VectorXd step = parameters - base_parameters_;
  state.x += work.slots[base_].by_parameter.x * step(columns).eval();
}

/// A sequence of a model that remembers: its frames in order, each from the history of those
/// before. `from`: the slot to start near; -1: none.
void SequenceEvaluator::walk_remembering(std::size_t s, int from, int thread,
                                         const Eigen::VectorXd& parameters, Derivative wanted) {
  const Sequence& sequence = sequences_[s];
  const mechanics::MeshModel& model = bound_[s]->model;
  const auto columns = static_cast<Eigen::Index>(bound_[s]->columns.size());
  const FrameWork::Slot* before = nullptr;
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    FrameWork& work = *frames_[s][f];
    FrameWork::Slot& slot = work.slots[last_];
    const auto& measured = sequence.frames[f].start;
    const bool is_rest = measured && options_.starts_are_near;
    const State& near = before && !is_rest ? before->state : measured ? *measured : sequence.start;
    if (from >= 0)
      start_from(work, from, bound_[s]->columns, parameters, slot.state);
    else
      slot.state = near;
    if (before)
      slot.start.state = before->end;
    else
      slot.start = model.never_strained();
    slot.start.duration_s = sequence.frames[f].duration_s;
    const auto solve = [&](bool is_near, bool may_predict) {
      // the change of the history that is carried along is that of the frame before
      if (wanted == Derivative::by_parameter) {
        if (before)
          slot.end_by_parameter = before->end_by_parameter;
        else
          slot.end_by_parameter.setZero(model.history_count(), columns);
      }
      work.failure.clear();
      return solve_frame(s, f, thread, parameters, {is_near, may_predict, wanted, &slot.start});
    };
    bool is_solved =
        solve(from >= 0 || before != nullptr || is_rest, from < 0 && before != nullptr && !is_rest);
    for (const State* start : {&near, measured ? &*measured : nullptr}) {
      if (is_solved || !start) continue;
      slot.state = *start;
      is_solved = solve(false, false);
    }
    if (!is_solved) return;
    if (model.end_of_step(slot.state.x, term_parameters_, slot.start, slot.end) !=
        mechanics::AssemblyStatus::ok) {
      work.failure = "what the material remembers of its path are no numbers";
      return;
    }
    before = &slot;
  }
}

}  // namespace tenter::estimation
