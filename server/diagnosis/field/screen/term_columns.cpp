// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/term_columns.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/model/catalogue.h"
#include "server/estimation/parallel.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/sequences/sensors/sequence_sensors.h"
#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/mechanics/equilibrium/sensitivity.h"

namespace tenter::diagnosis {
namespace {

using mechanics::AssemblyStatus;
using mechanics::EquilibriumSolver;
using mechanics::History;
using mechanics::MeshModel;

constexpr double kTolerance_N = 1e-8;

/// Terms that share a mesh: all that are elastic together; each that remembers by itself, so that
/// what its history owes to parameters stays small.
struct Part {
  MeshModel mesh;
  Eigen::VectorXd values;
  std::vector<Eigen::Index> own;      ///< its parameters that are wanted
  std::vector<Eigen::Index> columns;  ///< where they go in the result
  // of terms that remember
  History history = {};
  Eigen::MatrixXd change = {};
};

struct Group {
  model::Model model;
  std::vector<Eigen::Index> own, columns;
  bool remembers = false;
};

std::vector<Group> grouped(const std::vector<model::Term>& terms,
                           const std::vector<model::Field>& fields) {
  std::vector<Group> groups(1);  // the first one has all that are elastic
  groups.front().model.fields = fields;
  Eigen::Index column = 0;
  Eigen::Index elastic = 0;
  for (const model::Term& term : terms) {
    const bool remembers = model::find_law(term.law.name)->path_dependent;
    if (remembers) groups.push_back({{}, {}, {}, true});
    Group& group = remembers ? groups.back() : groups.front();
    if (remembers) group.model.fields = fields;
    group.model.terms.push_back(term);
    // ids of variants may be alike
    group.model.terms.back().id = "added_" + std::to_string(column);
    Eigen::Index at = remembers ? 0 : elastic;
    for (const model::Parameter& p : term.law.parameters) {
      if (!p.fixed) {
        group.own.push_back(at);
        group.columns.push_back(column);
      }
      ++at;
      ++column;
    }
    if (!remembers) elastic = at;
  }
  if (groups.front().model.terms.empty()) groups.erase(groups.begin());
  return groups;
}

/// One sequence, frame after frame.
class Walk {
 public:
  Walk(const FieldFit& fit, const FieldData& data, std::size_t sequence, Eigen::Index columns,
       const estimation::SequenceSensors& sensors)
      : fit_(fit),
        sequence_(data.sequences[sequence]),
        index_(sequence),
        columns_(columns),
        sensors_(sensors) {}

  Expected<void> run(const std::vector<Group>& groups, const std::vector<std::vector<int>>& row_of,
                     Eigen::MatrixXd& result) {
    auto own = MeshModel::make(fit_.at.model, sequence_.cloth);
    if (!own) return tl::unexpected(own.error());
    base_.emplace(std::move(*own));
    parameters_ = mechanics::term_parameters(fit_.at.model);
    remembers_ = base_->history_count() > 0;
    if (remembers_) {
      history_ = base_->never_strained();
      change_.setZero(base_->history_count(), columns_);
    }
    std::vector<Part> parts;
    for (const Group& group : groups) {
      auto mesh = MeshModel::make(group.model, sequence_.cloth);
      if (!mesh) return tl::unexpected(mesh.error());
      Part part{std::move(*mesh), mechanics::term_parameters(group.model), group.own,
                group.columns};
      if (group.remembers) {
        part.history = part.mesh.never_strained();
        part.change.setZero(part.mesh.history_count(), static_cast<Eigen::Index>(part.own.size()));
      }
      parts.push_back(std::move(part));
    }
    solvers_.resize(sequence_.boundaries.size());
    const estimation::Observations channels(sequence_);
    for (std::size_t f = 0; f < sequence_.frames.size(); ++f)
      if (auto ok = frame(f, parts, channels, row_of[f], result); !ok) return ok;
    if (!sensors_.is_empty()) show(channels, row_of, result);
    return {};
  }

 private:
  Expected<void> frame(std::size_t f, std::vector<Part>& parts,
                       const estimation::Observations& channels, const std::vector<int>& row_of,
                       Eigen::MatrixXd& result) {
    const auto& measured = sequence_.frames[f];
    auto& solver = solvers_[static_cast<std::size_t>(measured.boundary)];
    const auto& boundary = sequence_.boundaries[static_cast<std::size_t>(measured.boundary)];
    if (!solver) {
      auto made = EquilibriumSolver::make(*base_, boundary);
      if (!made) return tl::unexpected(made.error());
      solver.emplace(std::move(*made));
    }
    mechanics::State state = fit_.states[index_][f];
    mechanics::Loads loads = sequence_.loads;
    loads.cord_force_N = measured.cord_force_N;
    if (!sensors_.is_empty())
      sensors_.act(sequence_, index_, f, fit_.at.fit.parameters, loads, state.clips);
    mechanics::EquilibriumOptions options;
    options.tolerance_N = kTolerance_N;
    options.start_is_near = true;
    options.predict = false;
    history_.duration_s = measured.duration_s;
    const auto solved =
        solver->solve(parameters_, loads, state, options, remembers_ ? &history_ : nullptr);
    if (!solved) return tl::unexpected(solved.error());
    if (!solved->is_good(options))
      return fail(ErrorKind::refused, "sequence \"" + sequence_.name + "\", frame " +
                                          std::to_string(f + 1) + ": " +
                                          describe(*solved, options));
    Eigen::MatrixXd partial = Eigen::MatrixXd::Zero(state.x.size(), columns_);
    for (Part& part : parts)
      if (auto ok = pull(part, state, measured.duration_s, partial); !ok) return ok;
    if (remembers_ && base_->add_gradient_by_history(state.x, parameters_, history_, change_,
                                                     partial) != AssemblyStatus::ok)
      return fail(ErrorKind::refused, "a derivative by the history is not finite");
    const auto moved = sensitivity_by_force(*solver, parameters_, state, partial);
    if (!moved) return tl::unexpected(moved.error());
    if (remembers_) {
      const std::vector<Eigen::Index> none(static_cast<std::size_t>(columns_), -1);
      if (base_->carry_history_change(state.x, parameters_, history_, moved->x, none, change_) !=
              AssemblyStatus::ok ||
          base_->end_of_step(state.x, parameters_, history_, history_.state) != AssemblyStatus::ok)
        return fail(ErrorKind::refused, "a derivative of the history is not finite");
    }
    estimation::Observation seen;
    Eigen::RowVectorXd change;
    estimation::Readings predicted;
    if (!sensors_.is_empty()) {
      predicted.value.setZero(channels.count());
      predicted.by_p.setZero(channels.count(), sensors_.parameter_count());
    }
    for (int c = 0; c < channels.count(); ++c) {
      const int row = row_of[static_cast<std::size_t>(c)];
      if (row < 0 && sensors_.is_empty()) continue;
      channels.observe(sequence_, c, {boundary, state, solved->by_node}, seen);
      change_of(seen, *moved, change);
      if (sensors_.is_empty()) {
        result.row(row) = change / channels.sigma(sequence_, c);
        continue;
      }
      predicted.value[c] = seen.value;
      raw_.resize(sequence_.frames.size());
      raw_[f].resize(channels.count(), columns_);
      raw_[f].row(c) = change;
    }
    if (!sensors_.is_empty()) predicted_.push_back(std::move(predicted));
    return {};
  }

  /// dG/dq of a part's own parameters at a fitted frame; its memory goes on to the frame's end.
  Expected<void> pull(Part& part, const mechanics::State& state, double duration_s,
                      Eigen::MatrixXd& partial) {
    const bool remembers = part.history.state.size() > 0;
    part.history.duration_s = duration_s;
    Eigen::MatrixXd forces;
    const auto fine = [](AssemblyStatus status) { return status == AssemblyStatus::ok; };
    if (!fine(part.mesh.gradient_by_parameter(state.x, part.values, forces, nullptr,
                                              remembers ? &part.history : nullptr)))
      return fail(ErrorKind::refused, "a derivative by a candidate is not finite");
    Eigen::MatrixXd wanted = forces(Eigen::indexing::all, part.own);
    if (remembers) {
      const Eigen::MatrixXd still = Eigen::MatrixXd::Zero(state.x.size(), wanted.cols());
      if (!fine(part.mesh.add_gradient_by_history(state.x, part.values, part.history, part.change,
                                                  wanted)) ||
          !fine(part.mesh.carry_history_change(state.x, part.values, part.history, still, part.own,
                                               part.change)) ||
          !fine(part.mesh.end_of_step(state.x, part.values, part.history, part.history.state)))
        return fail(ErrorKind::refused, "a candidate's memory is not finite");
    }
    for (std::size_t k = 0; k < part.columns.size(); ++k)
      partial.col(part.columns[k]) += wanted.col(static_cast<Eigen::Index>(k));
    return {};
  }

  /// What the model's instruments make of the columns: their derivatives are linear in those of the
  /// readings, so as many columns as the model has parameters go through at a time, in their
  /// places.
  void show(const estimation::Observations& channels, const std::vector<std::vector<int>>& row_of,
            Eigen::MatrixXd& result) {
    const Eigen::Index places = parameters_.size();
    estimation::Readings shown;
    for (Eigen::Index first = 0; first < columns_; first += places) {
      const Eigen::Index count = std::min(places, columns_ - first);
      for (std::size_t f = 0; f < predicted_.size(); ++f) {
        predicted_[f].by_p.setZero();
        predicted_[f].by_p.leftCols(count) = raw_[f].middleCols(first, count);
      }
      for (std::size_t f = 0; f < predicted_.size(); ++f) {
        sensors_.show(sequence_, index_, f, predicted_, fit_.at.fit.parameters, true, shown);
        for (int c = 0; c < channels.count(); ++c) {
          const int row = row_of[f][static_cast<std::size_t>(c)];
          if (row >= 0)
            result.row(row).segment(first, count) =
                shown.by_p.row(c).head(count) / channels.sigma(sequence_, c);
        }
      }
    }
  }

  const FieldFit& fit_;
  const estimation::Sequence& sequence_;
  std::size_t index_;
  Eigen::Index columns_;
  const estimation::SequenceSensors& sensors_;
  // of models with corrections: what the frames show, and by the columns, before instruments
  std::vector<estimation::Readings> predicted_;
  std::vector<Eigen::MatrixXd> raw_;
  std::optional<MeshModel> base_;
  std::vector<std::optional<EquilibriumSolver>> solvers_;
  Eigen::VectorXd parameters_;
  bool remembers_ = false;
  History history_;
  Eigen::MatrixXd change_;
};

}  // namespace

Expected<Eigen::MatrixXd> correction_columns(
    const FieldFit& fit, const FieldData& data,
    const std::vector<model::SensorCorrection>& corrections, int threads) {
  model::Model model = fit.at.model;
  const auto own = static_cast<Eigen::Index>(estimation::parameters_of(model).size());
  estimation::SequenceOptions options;
  options.threads = threads;
  options.tolerance_N = kTolerance_N;
  options.starts_are_near = true;
  options.weighting.rule = estimation::WeightingRule::by_noise;
  Eigen::Index columns = 0;
  for (std::size_t k = 0; k < corrections.size(); ++k) {
    model.corrections.push_back(corrections[k]);
    model.corrections.back().id = "added_" + std::to_string(k);  // ids of variants may be alike
    for (const model::Parameter& p : corrections[k].parameters) {
      if (!p.fixed) options.moving.push_back(own + columns);
      ++columns;
    }
  }
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(fit.rows.size()), columns);
  if (options.moving.empty()) return result;
  std::vector<estimation::Sequence> sequences = data.sequences;
  for (std::size_t s = 0; s < fit.states.size(); ++s)
    for (std::size_t f = 0; f < fit.states[s].size(); ++f)
      sequences[s].frames[f].start = fit.states[s][f];
  auto evaluator = estimation::SequenceEvaluator::make(model, std::move(sequences), options);
  if (!evaluator) return tl::unexpected(evaluator.error());
  Eigen::VectorXd residuals;
  estimation::RowMatrix jacobian;
  if (evaluator->evaluate(estimation::parameter_values(model), residuals, &jacobian) !=
      mechanics::PathStatus::ok)
    return fail(ErrorKind::refused, evaluator->failure());
  result = jacobian.rightCols(columns);
  return result;
}

Expected<Eigen::MatrixXd> term_columns(const FieldFit& fit, const FieldData& data,
                                       const std::vector<model::Term>& terms,
                                       const std::vector<model::Field>& fields, int threads) {
  Eigen::Index columns = 0;
  for (const model::Term& term : terms)
    columns += static_cast<Eigen::Index>(term.law.parameters.size());
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(fit.rows.size()), columns);
  if (columns == 0) return result;
  // [sequence][frame][channel]
  std::vector<std::vector<std::vector<int>>> row_of;
  for (const estimation::Sequence& sequence : data.sequences)
    row_of.emplace_back(
        sequence.frames.size(),
        std::vector<int>(static_cast<std::size_t>(estimation::Observations(sequence).count()), -1));
  for (std::size_t r = 0; r < fit.rows.size(); ++r)
    row_of[static_cast<std::size_t>(fit.rows[r].curve)][static_cast<std::size_t>(fit.rows[r].frame)]
          [static_cast<std::size_t>(fit.rows[r].channel)] = static_cast<int>(r);
  const std::vector<Group> groups = grouped(terms, fields);
  const auto sensors = estimation::SequenceSensors::make(fit.at.model, data.sequences);
  if (!sensors) return tl::unexpected(sensors.error());
  std::vector<Expected<void>> done(data.sequences.size());
  estimation::in_parallel(threads, static_cast<int>(done.size()), [&](int, int s) {
    const auto k = static_cast<std::size_t>(s);
    done[k] = Walk(fit, data, k, columns, *sensors).run(groups, row_of[k], result);
  });
  for (const auto& one : done)
    if (!one) return tl::unexpected(one.error());
  return result;
}

}  // namespace tenter::diagnosis
