// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/screen/column_walk.h"

#include <algorithm>
#include <utility>

#include "common/model/catalogue.h"
#include "server/mechanics/assembly/history/held_step.h"

namespace tenter::diagnosis {

using mechanics::AssemblyStatus;
using mechanics::EquilibriumSolver;
using mechanics::MeshModel;

namespace {

constexpr double kTolerance_N = 1e-8;

using ByNode = estimation::Observation::ByNode;

/// estimation::change_of for many columns and thousands of points: whole rows at a time. Forces are
/// few, and look at few nodes.
class Change {
 public:
  explicit Change(const mechanics::Sensitivity& moved) : x_(moved.x), gradient_(moved.gradient) {}

  void of(const estimation::Observation& seen, Eigen::RowVectorXd& change) const {
    change.setZero(x_.cols());
    for (const ByNode& part : seen.by_x)
      for (int c = 0; c < 3; ++c)
        if (part.by[c] != 0.0)
          change.noalias() += part.by[c] * x_.row(3 * static_cast<Eigen::Index>(part.node) + c);
    for (const ByNode& part : seen.by_gradient)
      change.noalias() +=
          part.by.transpose() * gradient_.middleRows<3>(3 * static_cast<Eigen::Index>(part.node));
  }

 private:
  estimation::RowMatrix x_;
  const Eigen::MatrixXd& gradient_;
};

}  // namespace

std::vector<TermGroup> grouped(const Added& added) {
  std::vector<TermGroup> groups(1);  // the first one has all that are elastic
  int first = 0;                     // of the term's parameters among those of all
  Eigen::Index elastic = 0;
  for (const model::Term& term : added.terms) {
    const int last = first + static_cast<int>(term.law.parameters.size());
    const auto from =
        std::lower_bound(added.wanted_of_terms.begin(), added.wanted_of_terms.end(), first);
    const auto to = std::lower_bound(from, added.wanted_of_terms.end(), last);
    if (from != to) {
      const bool remembers = model::find_law(term.law.name)->path_dependent;
      if (remembers) groups.push_back({{}, {}, {}, true});
      TermGroup& group = remembers ? groups.back() : groups.front();
      group.model.terms.push_back(term);
      // ids of variants may be alike
      group.model.terms.back().id = "added_" + std::to_string(first);
      for (auto p = from; p != to; ++p) {
        group.own.push_back((remembers ? 0 : elastic) + *p - first);
        group.columns.push_back(p - added.wanted_of_terms.begin());
      }
      if (!remembers) elastic += last - first;
    }
    first = last;
  }
  if (groups.front().model.terms.empty()) groups.erase(groups.begin());
  for (TermGroup& group : groups) group.model.fields = added.fields;
  return groups;
}

ColumnWalk::ColumnWalk(const ColumnTask& task, std::size_t sequence)
    : task_(task),
      index_(sequence),
      sequence_(task.data.sequences[sequence]),
      channels_(sequence_),
      terms_(static_cast<Eigen::Index>(task.added.wanted_of_terms.size())),
      corrections_(static_cast<Eigen::Index>(task.added.wanted_of_corrections.size())) {
  const Eigen::Index first = task.own_sensors.parameter_count();
  for (const int p : task.added.wanted_of_corrections) wanted_.push_back(first + p);
  const std::vector<Eigen::Index> felt = task.all_sensors.felt(index_);
  std::set_intersection(wanted_.begin(), wanted_.end(), felt.begin(), felt.end(),
                        std::back_inserter(rig_));
}

Expected<void> ColumnWalk::run(const std::vector<std::vector<int>>& row_of,
                               estimation::RowMatrix& result) {
  if (auto ok = set_up(); !ok) return ok;
  for (std::size_t f = 0; f < sequence_.frames.size(); ++f)
    if (auto ok = frame(f, row_of[f], result); !ok) return ok;
  if (!own_.empty()) show_terms(row_of, result);
  if (!all_.empty()) show_corrections(row_of, result);
  return {};
}

Expected<void> ColumnWalk::set_up() {
  auto own = MeshModel::make(task_.fit.at.model, sequence_.cloth);
  if (!own) return tl::unexpected(own.error());
  base_.emplace(std::move(*own));
  term_parameters_ = mechanics::term_parameters(task_.fit.at.model);
  remembers_ = base_->history_count() > 0;
  if (remembers_) {
    history_ = base_->never_strained();
    change_.setZero(base_->history_count(), terms_);
    rig_change_.setZero(base_->history_count(), static_cast<Eigen::Index>(rig_.size()));
  }
  for (const TermGroup& group : task_.groups) {
    auto mesh = MeshModel::make(group.model, sequence_.cloth);
    if (!mesh) return tl::unexpected(mesh.error());
    Part part{group, std::move(*mesh), mechanics::term_parameters(group.model)};
    if (group.remembers) {
      part.history = part.mesh.never_strained();
      part.change.setZero(part.mesh.history_count(), static_cast<Eigen::Index>(group.own.size()));
    }
    parts_.push_back(std::move(part));
  }
  solvers_.resize(sequence_.boundaries.size());
  if (terms_ > 0 && !task_.own_sensors.is_empty()) {
    own_.resize(sequence_.frames.size());
    raw_.resize(sequence_.frames.size());
  }
  if (corrections_ > 0) all_.resize(sequence_.frames.size());
  return {};
}

/// The fitted rest again, with its factor.
Expected<mechanics::EquilibriumResult> ColumnWalk::come_to_rest(std::size_t f,
                                                                EquilibriumSolver& solver,
                                                                mechanics::State& state) {
  const estimation::SequenceFrame& measured = sequence_.frames[f];
  mechanics::Loads loads = sequence_.loads;
  loads.cord_force_N = measured.cord_force_N;
  if (!task_.own_sensors.is_empty())
    task_.own_sensors.act(sequence_, index_, f, task_.parameters, loads, state.clips);
  mechanics::EquilibriumOptions options;
  options.tolerance_N = kTolerance_N;
  options.start_is_near = true;
  options.predict = false;
  history_.duration_s = measured.duration_s;
  auto solved =
      solver.solve(term_parameters_, loads, state, options, remembers_ ? &history_ : nullptr);
  const bool is_rest = solved && solved->is_good(options);
  if (solved && (!is_rest || solver.factor() == nullptr))
    return fail(ErrorKind::refused,
                "sequence \"" + sequence_.name + "\", frame " + std::to_string(f + 1) + ": " +
                    (is_rest ? "no derivative, since a motion of the sheet costs nothing; fix what "
                               "the captures do not determine"
                             : describe(*solved, options)));
  return solved;
}

Expected<void> ColumnWalk::frame(std::size_t f, const std::vector<int>& row_of,
                                 estimation::RowMatrix& result) {
  const auto of = static_cast<std::size_t>(sequence_.frames[f].boundary);
  const mechanics::Boundary& boundary = sequence_.boundaries[of];
  if (!solvers_[of]) {
    auto made = EquilibriumSolver::make(*base_, boundary);
    if (!made) return tl::unexpected(made.error());
    solvers_[of].emplace(std::move(*made));
  }
  EquilibriumSolver& solver = *solvers_[of];
  mechanics::State state = task_.fit.states[index_][f];
  const auto solved = come_to_rest(f, solver, state);
  if (!solved) return tl::unexpected(solved.error());

  mechanics::Sensitivity by_rig_faults;
  std::vector<Eigen::Index> felt;
  if (auto ok = by_rig(f, solver, state, by_rig_faults, felt); !ok) return ok;
  const auto moved = by_terms(f, solver, state);
  if (!moved) return tl::unexpected(moved.error());
  if (remembers_ &&
      base_->end_of_step(state.x, term_parameters_, history_, history_.state) != AssemblyStatus::ok)
    return fail(ErrorKind::refused, "what the material remembers of its path are no numbers");

  const int count = channels_.count();
  if (!own_.empty()) raw_[f].resize(count, terms_);
  for (auto* readings : {&own_, &all_})
    if (!readings->empty()) (*readings)[f].value.resize(count);
  if (!all_.empty()) all_[f].by_p.setZero(count, task_.all_sensors.parameter_count());
  const Change by_term(*moved), by_fault(by_rig_faults);
  estimation::Observation seen;
  Eigen::RowVectorXd change;
  for (int c = 0; c < count; ++c) {
    const int row = row_of[static_cast<std::size_t>(c)];
    if (row < 0 && own_.empty() && all_.empty()) continue;
    channels_.observe(sequence_, c, {boundary, state, solved->by_node}, seen);
    if (!all_.empty()) {
      all_[f].value[c] = seen.value;
      by_fault.of(seen, change);
      if (!felt.empty()) all_[f].by_p.row(c)(felt) = change;
    }
    if (terms_ == 0) continue;
    by_term.of(seen, change);
    if (own_.empty()) {
      if (row >= 0) result.row(row).head(terms_) = change / channels_.sigma(sequence_, c);
      continue;
    }
    own_[f].value[c] = seen.value;
    raw_[f].row(c) = change;
  }
  return {};
}

/// dG/dq of a part's wanted parameters at a fitted frame; its memory goes on to the frame's end.
Expected<void> ColumnWalk::pull(Part& part, const mechanics::State& state, double duration_s,
                                Eigen::MatrixXd& partial) {
  const TermGroup& group = part.group;
  Eigen::MatrixXd force;
  AssemblyStatus status = AssemblyStatus::ok;
  if (group.remembers) {
    part.history.duration_s = duration_s;
    force.setZero(state.x.size(), static_cast<Eigen::Index>(group.own.size()));
    status = take_held_step(part.mesh, state.x, part.values, group.own, part.history, part.change,
                            force);
  } else {
    Eigen::MatrixXd all;
    status = part.mesh.gradient_by_parameter(state.x, part.values, all);
    if (status == AssemblyStatus::ok) force = all(Eigen::indexing::all, group.own);
  }
  if (status != AssemblyStatus::ok)
    return fail(ErrorKind::refused, "a derivative by a candidate is not finite");
  for (std::size_t k = 0; k < group.columns.size(); ++k)
    partial.col(group.columns[k]) = force.col(static_cast<Eigen::Index>(k));
  return {};
}

Expected<mechanics::Sensitivity> ColumnWalk::by_terms(std::size_t f, EquilibriumSolver& solver,
                                                      const mechanics::State& state) {
  if (terms_ == 0) return mechanics::Sensitivity{};
  Eigen::MatrixXd partial = Eigen::MatrixXd::Zero(state.x.size(), terms_);
  for (Part& part : parts_)
    if (auto ok = pull(part, state, sequence_.frames[f].duration_s, partial); !ok)
      return tl::unexpected(ok.error());
  if (remembers_ && base_->add_gradient_by_history(state.x, term_parameters_, history_, change_,
                                                   partial) != AssemblyStatus::ok)
    return fail(ErrorKind::refused, "a derivative by the history is not finite");
  auto moved = sensitivity_by_force(solver, term_parameters_, state, partial);
  const std::vector<Eigen::Index> none(static_cast<std::size_t>(terms_), -1);
  if (moved && remembers_ &&
      base_->carry_history_change(state.x, term_parameters_, history_, moved->x, none, change_) !=
          AssemblyStatus::ok)
    return fail(ErrorKind::refused, "a derivative of the history is not finite");
  return moved;
}

/// By the faults of the rig that this frame feels: `felt` are the columns of `moved`, as
/// all_sensors counts parameters.
Expected<void> ColumnWalk::by_rig(std::size_t f, EquilibriumSolver& solver,
                                  const mechanics::State& state, mechanics::Sensitivity& moved,
                                  std::vector<Eigen::Index>& felt) {
  if (rig_.empty()) return {};
  mechanics::OuterChange outer =
      task_.all_sensors.outer_change(sequence_, index_, f, task_.parameters, rig_);
  const std::vector<Eigen::Index> none;
  if (remembers_) {  // what a frame does not feel may have come before
    auto along =
        sensitivity_along_path(solver, term_parameters_, state, &none, rig_change_, &outer);
    if (!along) return tl::unexpected(along.error());
    moved = std::move(*along);
    felt = rig_;
    return {};
  }
  std::vector<Eigen::Index> places;
  for (std::size_t k = 0; k < rig_.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    if (outer.load_N.col(column).isZero(0.0) && outer.held_m.col(column).isZero(0.0)) continue;
    places.push_back(column);
    felt.push_back(rig_[k]);
  }
  if (places.empty()) return {};
  outer.load_N = outer.load_N(Eigen::indexing::all, places).eval();
  outer.held_m = outer.held_m(Eigen::indexing::all, places).eval();
  auto change = sensitivity_by_parameter(solver, term_parameters_, state, &none, &outer);
  if (!change) return tl::unexpected(change.error());
  moved = std::move(*change);
  return {};
}

/// What the model's instruments make of the columns of terms: their derivatives are linear in those
/// of the readings, so as many columns as the model has parameters go through at a time, in their
/// places.
void ColumnWalk::show_terms(const std::vector<std::vector<int>>& row_of,
                            estimation::RowMatrix& result) {
  const Eigen::Index places = term_parameters_.size();
  const Eigen::VectorXd parameters = task_.parameters.head(task_.own_sensors.parameter_count());
  estimation::Readings shown;
  for (Eigen::Index first = 0; first < terms_; first += places) {
    const Eigen::Index count = std::min(places, terms_ - first);
    for (std::size_t f = 0; f < own_.size(); ++f) {
      own_[f].by_p.setZero(channels_.count(), parameters.size());
      own_[f].by_p.leftCols(count) = raw_[f].middleCols(first, count);
    }
    for (std::size_t f = 0; f < own_.size(); ++f) {
      task_.own_sensors.show(sequence_, index_, f, own_, parameters, true, shown);
      for (int c = 0; c < channels_.count(); ++c) {
        const int row = row_of[f][static_cast<std::size_t>(c)];
        if (row >= 0)
          result.row(row).segment(first, count) =
              shown.by_p.row(c).head(count) / channels_.sigma(sequence_, c);
      }
    }
  }
}

void ColumnWalk::show_corrections(const std::vector<std::vector<int>>& row_of,
                                  estimation::RowMatrix& result) {
  estimation::Readings shown;
  for (std::size_t f = 0; f < all_.size(); ++f) {
    task_.all_sensors.show(sequence_, index_, f, all_, task_.parameters, true, shown);
    for (int c = 0; c < channels_.count(); ++c) {
      const int row = row_of[f][static_cast<std::size_t>(c)];
      if (row >= 0)
        result.row(row).tail(corrections_) =
            shown.by_p.row(c)(wanted_) / channels_.sigma(sequence_, c);
    }
  }
}

}  // namespace tenter::diagnosis
