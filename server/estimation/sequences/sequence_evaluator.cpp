// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/sequences/sequence_evaluator.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "server/estimation/parallel.h"
#include "server/estimation/sequences/sequence_work.h"

namespace tenter::estimation {

using mechanics::EquilibriumSolver;
using mechanics::MeshModel;
using mechanics::PathStatus;
using mechanics::Sensitivity;
using mechanics::State;

namespace {

void add(const SequenceCost& part, SequenceCost& sum) {
  sum.equilibria += part.equilibria;
  sum.iterations += part.iterations;
  sum.factorisations += part.factorisations;
  sum.evaluations += part.evaluations;
  sum.sensitivities += part.sensitivities;
  sum.equilibrium_s += part.equilibrium_s;
  sum.sensitivity_s += part.sensitivity_s;
}

/// Whether Jacobians are by a flat parameter.
bool moves(Eigen::Index parameter, const SequenceOptions& options) {
  return options.moving.empty() ||
         std::find(options.moving.begin(), options.moving.end(), parameter) != options.moving.end();
}

}  // namespace

Expected<SequenceEvaluator> SequenceEvaluator::make(const model::Model& model,
                                                    std::vector<Sequence> sequences,
                                                    const SequenceOptions& options) {
  if (sequences.empty()) return bad_input("there is no sequence to compare with");
  SequenceEvaluator result;
  result.options_ = options;
  for (const Sequence& sequence : sequences)
    if (auto ok = check(sequence); !ok) return tl::unexpected(ok.error());
  auto sensors = SequenceSensors::make(model, sequences);
  if (!sensors) return tl::unexpected(sensors.error());
  result.sensors_ = std::move(*sensors);
  result.parameter_count_ = result.sensors_.parameter_count();
  int first_block = 0;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const Sequence& sequence = sequences[s];
    auto made = MeshModel::make(model, sequence.cloth);
    if (!made) return bad_input("sequence \"" + sequence.name + "\": " + made.error().message);
    auto bound =
        std::make_shared<Bound>(Bound{std::move(*made), Observations(sequence), {}, {}, {}, {}});
    for (const mechanics::Boundary& boundary : sequence.boundaries)
      if (auto solver = EquilibriumSolver::make(bound->model, boundary); !solver)
        return bad_input("sequence \"" + sequence.name + "\": " + solver.error().message);
    const int channels = bound->channels.count();
    bound->row_of.assign(sequence.frames.size(),
                         std::vector<int>(static_cast<std::size_t>(channels), -1));
    int blocks = 0;
    for (int c = 0; c < channels; ++c) {
      for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
        blocks = std::max(blocks, sequence.frames[f].block + 1);
        if (std::isnan(bound->channels.measured(sequence.frames[f], c))) continue;
        bound->row_of[f][static_cast<std::size_t>(c)] = static_cast<int>(result.rows_.size());
        result.rows_.push_back(
            {static_cast<int>(s), c, static_cast<int>(f), first_block + sequence.frames[f].block});
      }
    }
    first_block += blocks;
    result.term_parameter_count_ = bound->model.parameter_count();
    for (Eigen::Index p = 0; p < result.term_parameter_count_; ++p)
      if (moves(p, options)) bound->terms.push_back(p);
    for (const Eigen::Index p : result.sensors_.felt(s))
      if (moves(p, options)) bound->rig.push_back(p);
    bound->columns = bound->terms;
    bound->columns.insert(bound->columns.end(), bound->rig.begin(), bound->rig.end());
    result.readings_.emplace_back(sequence.frames.size());
    result.remembers_ = bound->model.history_count() > 0;
    result.bound_.push_back(std::move(bound));
    auto& works = result.frames_.emplace_back();
    for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
      works.push_back(std::make_shared<FrameWork>());
      result.all_frames_.emplace_back(s, f);
      if (f == 0 || sequence.frames[f].start) result.runs_.push_back({s, f, f});
      result.runs_.back().last = f;
    }
  }
  if (result.rows_.empty()) return bad_input("the sequences hold no measured value");
  auto weights = row_weights(result.rows_, sequences, options.weighting);
  if (!weights) return tl::unexpected(weights.error());
  result.weights_ = std::move(*weights);
  result.shown_.resize(static_cast<std::size_t>(std::max(1, options.threads)));
  result.sequences_ = std::move(sequences);
  result.solvers_.resize(static_cast<std::size_t>(std::max(1, options.threads)));
  for (auto& of_thread : result.solvers_)
    for (const Sequence& sequence : result.sequences_)
      of_thread.emplace_back().resize(sequence.boundaries.size());
  return result;
}

PathStatus SequenceEvaluator::evaluate(const Eigen::VectorXd& parameters,
                                       Eigen::VectorXd& residuals, RowMatrix* jacobian) {
  // where the residuals of a step are wanted its Jacobian follows, as most steps are taken
  const bool wants_sensitivity = jacobian != nullptr || accuracy_ == Accuracy::stepping;
  const bool is_known = last_ >= 0 && parameters == last_parameters_ &&
                        (last_accuracy_ == Accuracy::exact || accuracy_ == Accuracy::stepping) &&
                        (last_has_sensitivity_ || !wants_sensitivity);
  if (!is_known) {
    const auto wanted = wants_sensitivity ? Derivative::by_parameter : Derivative::none;
    if (!solve_all(parameters, wanted)) return PathStatus::no_equilibrium;
  }
  if (last_has_sensitivity_ && (jacobian || base_ < 0)) {
    base_ = last_;
    base_parameters_ = parameters;
  }
  residuals.resize(row_count());
  if (jacobian) jacobian->setZero(row_count(), parameter_count_);
  if (!sensors_.is_empty())
    write_as_shown(parameters, residuals, jacobian);
  else
    in_parallel(options_.threads, static_cast<int>(all_frames_.size()), [&](int, int k) {
      const auto [s, f] = all_frames_[static_cast<std::size_t>(k)];
      write_rows(s, f, residuals, jacobian);
    });
  states_.resize(sequences_.size());
  for (std::size_t s = 0; s < sequences_.size(); ++s) {
    states_[s].resize(frames_[s].size());
    for (std::size_t f = 0; f < frames_[s].size(); ++f)
      states_[s][f] = frames_[s][f]->slots[last_].state;
  }
  return residuals.allFinite() && (!jacobian || jacobian->allFinite()) ? PathStatus::ok
                                                                       : PathStatus::not_finite;
}

PathStatus SequenceEvaluator::evaluate_gradient(const Eigen::VectorXd& parameters, double& cost,
                                                Eigen::VectorXd& gradient) {
  if (remembers_ || !sensors_.is_empty()) {
    Eigen::VectorXd residuals;
    RowMatrix jacobian;
    const PathStatus status = evaluate(parameters, residuals, &jacobian);
    const Eigen::VectorXd weighted = weights_.cwiseProduct(residuals);
    cost = weighted.dot(residuals);
    gradient = 2.0 * (jacobian.transpose() * weighted);
    return status;
  }
  if (!solve_all(parameters, Derivative::of_cost)) return PathStatus::no_equilibrium;
  cost = 0.0;
  gradient.setZero(parameter_count_);
  for (const auto& [s, f] : all_frames_) {
    const FrameWork::Slot& slot = frames_[s][f]->slots[last_];
    cost += slot.cost;
    gradient += slot.cost_change;
  }
  return std::isfinite(cost) && gradient.allFinite() ? PathStatus::ok : PathStatus::not_finite;
}

/// Brings every frame to rest in the slots of `last_`; false, and nothing is known, where one does
/// not.
bool SequenceEvaluator::solve_all(const Eigen::VectorXd& parameters, Derivative wanted) {
  if (parameters.size() != parameter_count_) {
    failure_ = "the model has " + std::to_string(parameter_count_) + " parameters, given are " +
               std::to_string(parameters.size());
    last_ = -1;
    return false;
  }
  for (const auto& works : frames_) {
    for (const auto& work : works) {
      work->failure.clear();
      work->cost = {};
    }
  }
  const bool is_here = last_ >= 0 && parameters == last_parameters_;
  const int from = is_here ? last_ : base_;
  term_parameters_ = parameters.head(term_parameter_count_);
  last_ = base_ < 0 ? 0 : 1 - base_;
  if (remembers_) {
    in_parallel(options_.threads, static_cast<int>(sequences_.size()), [&](int thread, int k) {
      walk_remembering(static_cast<std::size_t>(k), from, thread, parameters, wanted);
    });
  } else if (from < 0) {
    in_parallel(options_.threads, static_cast<int>(runs_.size()), [&](int thread, int k) {
      walk(runs_[static_cast<std::size_t>(k)], thread, parameters, wanted);
    });
  } else {
    const bool gives_up = accuracy_ == Accuracy::stepping && !is_here && base_ >= 0;
    std::atomic<int> failed_at{static_cast<int>(all_frames_.size())};
    in_parallel(options_.threads, static_cast<int>(all_frames_.size()), [&](int thread, int k) {
      if (k > failed_at) return;  // the first one that fails is found whatever the threads do
      const auto [s, f] = all_frames_[static_cast<std::size_t>(k)];
      FrameWork& work = *frames_[s][f];
      State& state = work.slots[last_].state;
      start_from(work, from, bound_[s]->columns, parameters, state);
      SolveHow how{true, false, wanted, nullptr, gives_up};
      if (solve_frame(s, f, thread, parameters, how)) return;
      const auto& measured = sequences_[s].frames[f].start;
      if (!gives_up && (measured || base_ >= 0)) {
        work.failure.clear();
        state = measured ? *measured : work.slots[base_].state;
        how.is_near = false;
        if (solve_frame(s, f, thread, parameters, how)) return;
      }
      for (int at = failed_at; k < at && !failed_at.compare_exchange_weak(at, k);) {
      }
    });
  }
  for (const auto& works : frames_)
    for (const auto& work : works) add(work->cost, cost_);
  if (has_failed()) {
    last_ = -1;
    return false;
  }
  last_parameters_ = parameters;
  last_accuracy_ = accuracy_;
  last_has_sensitivity_ = wanted == Derivative::by_parameter;
  return true;
}

bool SequenceEvaluator::has_failed() {
  failure_.clear();
  for (const auto& [s, f] : all_frames_) {
    const std::string& why = frames_[s][f]->failure;
    if (why.empty()) continue;
    failure_ =
        "sequence \"" + sequences_[s].name + "\", frame " + std::to_string(f + 1) + ": " + why;
    return true;
  }
  return false;
}

/// Derivatives at the state that `solver` has just come to.
Expected<void> SequenceEvaluator::differentiate(std::size_t sequence, std::size_t frame,
                                                EquilibriumSolver& solver,
                                                const Eigen::VectorXd& parameters,
                                                Derivative wanted) {
  FrameWork::Slot& slot = frames_[sequence][frame]->slots[last_];
  if (wanted == Derivative::by_parameter) {
    const Bound& bound = *bound_[sequence];
    mechanics::OuterChange rig;
    if (!bound.rig.empty())
      rig = sensors_.outer_change(sequences_[sequence], sequence, frame, parameters, bound.rig);
    auto change = remembers_ ? sensitivity_along_path(solver, term_parameters_, slot.state,
                                                      &bound.terms, slot.end_by_parameter, &rig)
                             : sensitivity_by_parameter(solver, term_parameters_, slot.state,
                                                        &bound.terms, &rig);
    if (!change) return tl::unexpected(change.error());
    slot.by_parameter = std::move(*change);
    return {};
  }
  slot.cost = 0.0;
  Eigen::VectorXd by_x = Eigen::VectorXd::Zero(slot.state.x.size());
  Eigen::VectorXd by_gradient = by_x;
  each_row(sequence, frame, [&](int row, double residual, double sigma, const Observation& seen) {
    slot.cost += weights_[row] * residual * residual;
    const double share = 2.0 * weights_[row] * residual / sigma;
    for (const Observation::ByNode& part : seen.by_x)
      by_x.segment<3>(3 * static_cast<Eigen::Index>(part.node)) += share * part.by;
    for (const Observation::ByNode& part : seen.by_gradient)
      by_gradient.segment<3>(3 * static_cast<Eigen::Index>(part.node)) += share * part.by;
  });
  auto change = objective_by_parameter(solver, term_parameters_, slot.state, by_x, by_gradient);
  if (!change) return tl::unexpected(change.error());
  slot.cost_change = std::move(*change);
  return {};
}

/// visit(row, residual, sigma, observation) of every measured value of a frame.
template <class Visit>
void SequenceEvaluator::each_row(std::size_t sequence, std::size_t frame,
                                 const Visit& visit) const {
  const Sequence& measured = sequences_[sequence];
  const SequenceFrame& at = measured.frames[frame];
  const Bound& bound = *bound_[sequence];
  const FrameWork::Slot& slot = frames_[sequence][frame]->slots[last_];
  const RestState rest{measured.boundaries[static_cast<std::size_t>(at.boundary)], slot.state,
                       slot.by_node};
  Observation seen;
  for (int c = 0; c < bound.channels.count(); ++c) {
    const int row = bound.row_of[frame][static_cast<std::size_t>(c)];
    if (row < 0) continue;
    bound.channels.observe(measured, c, rest, seen);
    const double sigma = bound.channels.sigma(measured, c);
    visit(row, (seen.value - bound.channels.measured(at, c)) / sigma, sigma, seen);
  }
}

void SequenceEvaluator::write_rows(std::size_t sequence, std::size_t frame,
                                   Eigen::VectorXd& residuals, RowMatrix* jacobian) const {
  const Sensitivity& by_parameter = frames_[sequence][frame]->slots[last_].by_parameter;
  Eigen::RowVectorXd change;
  each_row(sequence, frame, [&](int row, double residual, double sigma, const Observation& seen) {
    residuals[row] = residual;
    if (!jacobian) return;
    change_of(seen, by_parameter, change);
    if (options_.moving.empty())
      jacobian->row(row) = change / sigma;
    else
      jacobian->row(row)(options_.moving) = change / sigma;
  });
}

/// What a frame shows on all channels, before any instrument.
void SequenceEvaluator::read_channels(std::size_t sequence, std::size_t frame, bool sensitivities) {
  const Sequence& measured = sequences_[sequence];
  const Bound& bound = *bound_[sequence];
  const FrameWork::Slot& slot = frames_[sequence][frame]->slots[last_];
  const auto boundary = static_cast<std::size_t>(measured.frames[frame].boundary);
  Readings& readings = readings_[sequence][frame];
  const int channels = bound.channels.count();
  readings.value.resize(channels);
  if (sensitivities) readings.by_p.setZero(channels, parameter_count_);
  Observation seen;
  Eigen::RowVectorXd change;
  for (int c = 0; c < channels; ++c) {
    bound.channels.observe(measured, c, {measured.boundaries[boundary], slot.state, slot.by_node},
                           seen);
    readings.value[c] = seen.value;
    if (!sensitivities) continue;
    change_of(seen, slot.by_parameter, change);
    readings.by_p.row(c)(bound.columns) = change;
  }
}

void SequenceEvaluator::write_shown(std::size_t sequence, std::size_t frame, const Readings& shown,
                                    Eigen::VectorXd& residuals, RowMatrix* jacobian) const {
  const Sequence& measured = sequences_[sequence];
  const Bound& bound = *bound_[sequence];
  for (int c = 0; c < bound.channels.count(); ++c) {
    const int row = bound.row_of[frame][static_cast<std::size_t>(c)];
    if (row < 0) continue;
    const double sigma = bound.channels.sigma(measured, c);
    residuals[row] = (shown.value[c] - bound.channels.measured(measured.frames[frame], c)) / sigma;
    if (!jacobian) continue;
    if (options_.moving.empty())
      jacobian->row(row) = shown.by_p.row(c) / sigma;
    else
      jacobian->row(row)(options_.moving) = shown.by_p.row(c)(options_.moving) / sigma;
  }
}

/// Residuals of a model with sensor corrections: a clock that runs apart shows a frame what others
/// predict, so that all are predicted before any is shown.
void SequenceEvaluator::write_as_shown(const Eigen::VectorXd& parameters,
                                       Eigen::VectorXd& residuals, RowMatrix* jacobian) {
  const bool sensitivities = jacobian != nullptr;
  const auto frames = static_cast<int>(all_frames_.size());
  in_parallel(options_.threads, frames, [&](int, int k) {
    const auto [s, f] = all_frames_[static_cast<std::size_t>(k)];
    read_channels(s, f, sensitivities);
  });
  in_parallel(options_.threads, frames, [&](int thread, int k) {
    const auto [s, f] = all_frames_[static_cast<std::size_t>(k)];
    Readings& shown = shown_[static_cast<std::size_t>(thread)];
    sensors_.show(sequences_[s], s, f, readings_[s], parameters, sensitivities, shown);
    write_shown(s, f, shown, residuals, jacobian);
  });
}

}  // namespace tenter::estimation
