// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/sequence_evaluator.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <thread>
#include <utility>

#include "server/estimation/sequences/material_location.h"
#include "server/mechanics/equilibrium/sensitivity.h"

namespace tenter::estimation {

using mechanics::EquilibriumOptions;
using mechanics::EquilibriumSolver;
using mechanics::MeshModel;
using mechanics::PathStatus;
using mechanics::Sensitivity;
using mechanics::State;

struct SequenceEvaluator::Bound {
  MeshModel model;
  std::vector<MaterialLocation> locations;
  std::vector<std::vector<int>> row_of;  ///< [frame][channel]; -1: not measured
};

struct SequenceEvaluator::FrameWork {
  State state;               ///< of the last evaluation
  State base;                ///< where the last Jacobian was taken
  Sensitivity by_parameter;  ///< there
  Eigen::VectorXd by_node;   ///< gradient of the potential at `state`
  std::string failure;
};

namespace {

/// Runs work(thread, 0) .. work(thread, count - 1) on as many threads; each writes only what is its
/// own.
void in_parallel(int threads, int count, const std::function<void(int, int)>& work) {
  std::atomic<int> next{0};
  const auto loop = [&](int thread) {
    for (int i = next++; i < count; i = next++) work(thread, i);
  };
  std::vector<std::thread> others;
  for (int t = 1; t < std::min(threads, count); ++t) others.emplace_back(loop, t);
  loop(0);
  for (std::thread& other : others) other.join();
}

double measured_value(const Sequence& sequence, std::size_t frame, int channel) {
  const auto points = static_cast<int>(sequence.points.size());
  const SequenceFrame& f = sequence.frames[frame];
  return channel < 3 * points ? f.points_m(channel % 3, channel / 3)
                              : f.forces_N[channel - 3 * points];
}

int channel_count(const Sequence& sequence) {
  return static_cast<int>(3 * sequence.points.size() + sequence.forces.size());
}

}  // namespace

Expected<SequenceEvaluator> SequenceEvaluator::make(const model::Model& model,
                                                    std::vector<Sequence> sequences,
                                                    const SequenceOptions& options) {
  if (sequences.empty()) return bad_input("there is no sequence to compare with");
  if (!model.corrections.empty())
    return bad_input("sensor corrections of sequences are not known yet");
  SequenceEvaluator result;
  result.options_ = options;
  int first_block = 0;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const Sequence& sequence = sequences[s];
    if (auto ok = check(sequence); !ok) return tl::unexpected(ok.error());
    auto made = MeshModel::make(model, sequence.cloth);
    if (!made) return bad_input("sequence \"" + sequence.name + "\": " + made.error().message);
    auto bound = std::make_shared<Bound>(Bound{std::move(*made), {}, {}});
    for (const mechanics::Boundary& boundary : sequence.boundaries)
      if (auto solver = EquilibriumSolver::make(bound->model, boundary); !solver)
        return bad_input("sequence \"" + sequence.name + "\": " + solver.error().message);
    for (const PointChannel& point : sequence.points)
      bound->locations.push_back(*locate(sequence.cloth.mesh, point.material_m));
    const int channels = channel_count(sequence);
    bound->row_of.assign(sequence.frames.size(),
                         std::vector<int>(static_cast<std::size_t>(channels), -1));
    int blocks = 0;
    for (int c = 0; c < channels; ++c) {
      for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
        blocks = std::max(blocks, sequence.frames[f].block + 1);
        if (std::isnan(measured_value(sequence, f, c))) continue;
        bound->row_of[f][static_cast<std::size_t>(c)] = static_cast<int>(result.rows_.size());
        result.rows_.push_back(
            {static_cast<int>(s), c, static_cast<int>(f), first_block + sequence.frames[f].block});
      }
    }
    first_block += blocks;
    result.parameter_count_ = bound->model.parameter_count();
    result.bound_.push_back(std::move(bound));
    auto& works = result.frames_.emplace_back();
    for (std::size_t f = 0; f < sequence.frames.size(); ++f)
      works.push_back(std::make_shared<FrameWork>());
  }
  if (result.rows_.empty()) return bad_input("the sequences hold no measured value");
  result.sequences_ = std::move(sequences);
  result.solvers_.resize(static_cast<std::size_t>(std::max(1, options.threads)));
  for (auto& of_thread : result.solvers_)
    for (const Sequence& sequence : result.sequences_)
      of_thread.emplace_back().resize(sequence.boundaries.size());
  return result;
}

PathStatus SequenceEvaluator::evaluate(const Eigen::VectorXd& parameters,
                                       Eigen::VectorXd& residuals, RowMatrix* jacobian) {
  failure_.clear();
  const auto collect_failure = [&] {
    for (std::size_t s = 0; s < frames_.size() && failure_.empty(); ++s)
      for (std::size_t f = 0; f < frames_[s].size() && failure_.empty(); ++f)
        if (!frames_[s][f]->failure.empty())
          failure_ = "sequence \"" + sequences_[s].name + "\", frame " + std::to_string(f + 1) +
                     ": " + frames_[s][f]->failure;
    return !failure_.empty();
  };
  for (const auto& works : frames_)
    for (const auto& work : works) work->failure.clear();

  if (!has_base_) {
    in_parallel(options_.threads, static_cast<int>(sequences_.size()),
                [&](int thread, int s) { walk(static_cast<std::size_t>(s), thread, parameters); });
    if (collect_failure()) return PathStatus::no_equilibrium;
  }
  std::vector<std::pair<std::size_t, std::size_t>> jobs;
  for (std::size_t s = 0; s < sequences_.size(); ++s)
    for (std::size_t f = 0; f < sequences_[s].frames.size(); ++f) jobs.emplace_back(s, f);
  const bool wants_sensitivity = jacobian != nullptr || !has_base_;
  in_parallel(options_.threads, static_cast<int>(jobs.size()), [&](int thread, int k) {
    const auto [s, f] = jobs[static_cast<std::size_t>(k)];
    FrameWork& work = *frames_[s][f];
    EquilibriumSolver& solver = solver_of(thread, s, f);
    work.state = work.base;
    if (has_base_) {
      work.state.x += work.by_parameter.x * (parameters - base_parameters_);
      if (solve_frame(s, f, solver, parameters, true, wants_sensitivity)) return;
      work.failure.clear();
      work.state = work.base;
    }
    solve_frame(s, f, solver, parameters, !has_base_, wants_sensitivity);
  });
  if (collect_failure()) return PathStatus::no_equilibrium;

  residuals.resize(row_count());
  if (jacobian) jacobian->setZero(row_count(), parameter_count_);
  states_.assign(sequences_.size(), {});
  for (const auto& [s, f] : jobs) {
    write_rows(s, f, residuals, jacobian);
    states_[s].push_back(frames_[s][f]->state);
    if (wants_sensitivity) frames_[s][f]->base = frames_[s][f]->state;
  }
  if (wants_sensitivity) {
    has_base_ = true;
    base_parameters_ = parameters;
  }
  return residuals.allFinite() && (!jacobian || jacobian->allFinite()) ? PathStatus::ok
                                                                       : PathStatus::not_finite;
}

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

/// All frames of a sequence one after the other, from its start: fills their `base`.
bool SequenceEvaluator::walk(std::size_t sequence, int thread, const Eigen::VectorXd& parameters) {
  State state = sequences_[sequence].start;
  for (std::size_t f = 0; f < frames_[sequence].size(); ++f) {
    FrameWork& work = *frames_[sequence][f];
    const auto& start = sequences_[sequence].frames[f].start;
    work.state = start ? *start : state;
    const bool is_near = f > 0 && !start;
    EquilibriumSolver& solver = solver_of(thread, sequence, f);
    if (!solve_frame(sequence, f, solver, parameters, is_near, false)) return false;
    state = work.state;
    work.base = state;
  }
  return true;
}

bool SequenceEvaluator::solve_frame(std::size_t sequence, std::size_t frame,
                                    EquilibriumSolver& solver, const Eigen::VectorXd& parameters,
                                    bool is_near, bool wants_sensitivity) {
  const Sequence& measured = sequences_[sequence];
  const SequenceFrame& at = measured.frames[frame];
  FrameWork& work = *frames_[sequence][frame];
  mechanics::Loads loads = measured.loads;
  loads.cord_force_N = at.cord_force_N;
  prescribe(measured, frame, !is_near, work.state);
  EquilibriumOptions options;
  options.tolerance_N = options_.tolerance_N;
  options.start_is_near = is_near;
  options.check_minimum = wants_sensitivity;
  options.predict = false;  // frames are solved by whichever thread is free
  auto solved = solver.solve(parameters, loads, work.state, options);
  if (!solved || !solved->is_good(options)) {
    work.failure = solved ? describe(*solved, options) : solved.error().message;
    return false;
  }
  work.by_node = std::move(solved->by_node);
  if (!wants_sensitivity) return true;
  auto change = sensitivity_by_parameter(solver, parameters, work.state);
  if (!change) {
    work.failure = change.error().message;
    return false;
  }
  work.by_parameter = std::move(*change);
  return true;
}

void SequenceEvaluator::write_rows(std::size_t sequence, std::size_t frame,
                                   Eigen::VectorXd& residuals, RowMatrix* jacobian) const {
  const Sequence& measured = sequences_[sequence];
  const Bound& bound = *bound_[sequence];
  const FrameWork& work = *frames_[sequence][frame];
  const mechanics::Boundary& boundary =
      measured.boundaries[static_cast<std::size_t>(measured.frames[frame].boundary)];
  const auto points = static_cast<int>(measured.points.size());
  for (int c = 0; c < channel_count(measured); ++c) {
    const int row = bound.row_of[frame][static_cast<std::size_t>(c)];
    if (row < 0) continue;
    double predicted = 0.0;
    double sigma = 0.0;
    Eigen::RowVectorXd by_p = Eigen::RowVectorXd::Zero(parameter_count_);
    if (c < 3 * points) {
      const MaterialLocation& place = bound.locations[static_cast<std::size_t>(c / 3)];
      sigma = measured.points[static_cast<std::size_t>(c / 3)].sigma_m;
      predicted = place.position(work.state.x)[c % 3];
      if (jacobian)
        for (std::size_t a = 0; a < 3; ++a)
          by_p += place.weight[a] *
                  work.by_parameter.x.row(3 * static_cast<Eigen::Index>(place.nodes[a]) + c % 3);
    } else {
      const ForceChannel& force = measured.forces[static_cast<std::size_t>(c - 3 * points)];
      const mechanics::Clip& clip = boundary.clips[static_cast<std::size_t>(force.clip)];
      sigma = force.sigma_N;
      // the cords bear what the cloth pulls and what the clip weighs
      const Eigen::Vector3d pull =
          mechanics::reaction(clip, work.state.x, work.by_node, Eigen::Vector3d::Zero()).force_N;
      predicted = -force.direction.dot(pull + clip.mass_kg * measured.loads.gravity_m_s2);
      if (jacobian)
        for (const int node : clip.nodes)
          by_p += force.direction.transpose() *
                  work.by_parameter.gradient.middleRows<3>(3 * static_cast<Eigen::Index>(node));
    }
    residuals[row] = (predicted - measured_value(measured, frame, c)) / sigma;
    if (jacobian) jacobian->row(row) = by_p / sigma;
  }
}

}  // namespace tenter::estimation
