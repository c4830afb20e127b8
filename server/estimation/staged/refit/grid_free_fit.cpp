// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/refit/grid_free_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace tenter::estimation {
namespace {

constexpr const char* kStage = "without_grid_error";

class GridFree {
 public:
  GridFree(const std::vector<OnTwoGrids>& measured, const GridFreeOptions& options)
      : measured_(measured), options_(options) {}

  Expected<GridFreeFit> run(model::Model model) {
    fit_.model = std::move(model);
    fit_.errors.resize(measured_.size());
    if (auto ok = estimate(true); !ok) return tl::unexpected(ok.error());
    for (int round = 1; round <= options_.most_rounds && !fit_.settled && !fit_.stopped; ++round) {
      const auto is_done =
          round == 1 && options_.start != nullptr ? refit_in_stages() : refit(round);
      if (!is_done) return tl::unexpected(is_done.error());
      fit_.rounds = round;
      if (!*is_done || fit_.stopped) break;
      const std::vector<GridError> before = fit_.errors;
      if (auto ok = estimate(true); !ok) return tl::unexpected(ok.error());
      if (fit_.stopped) break;
      fit_.change_sigmas = change_since(before);
      fit_.settled = fit_.change_sigmas < options_.settled_sigmas;
    }
    if (!fit_.stopped)
      if (auto ok = estimate(false); !ok) return tl::unexpected(ok.error());
    return std::move(fit_);
  }

 private:
  /// Of those that are fitted, or of the others.
  Expected<void> estimate(bool are_fitted) {
    for (std::size_t s = 0; s < measured_.size() && !fit_.stopped; ++s) {
      const OnTwoGrids& one = measured_[s];
      if (one.is_fitted != are_fitted) continue;
      if (options_.stage.on_progress && !options_.stage.on_progress({kStage, 0, 0, cost_})) {
        fit_.stopped = true;
        return {};
      }
      GridErrorOptions how;
      how.order = one.order;
      how.of_positions = true;
      how.share_as_sigma = options_.share_as_sigma;
      how.threads = options_.stage.threads;
      auto error = grid_error(fit_.model, one.coarse.sequence, one.fine, how);
      if (!error) return tl::unexpected(error.error());
      fit_.errors[s] = std::move(*error);
    }
    return {};
  }

  /// False where it could not be done.
  Expected<bool> refit(int round) {
    StageTask task;
    task.name = round == 1 ? kStage : std::string(kStage) + "_" + std::to_string(round);
    task.terms = all_terms();
    task.ties = options_.ties;
    task.guess = task.refine = false;
    task.sequences = fitted_sequences();
    auto record = fit_stage(fit_.model, task, options_.stage);
    if (!record) return tl::unexpected(record.error());
    cost_ = record->cost_after;
    fit_.stopped = record->stopped;
    const bool is_done = record->done;
    fit_.stages.push_back(std::move(*record));
    fit_.terms.push_back(task.terms);
    return is_done;
  }

  Expected<bool> refit_in_stages() {
    const std::vector<RoleSequence> sequences = fitted_sequences();
    StagedOptions how = options_.staged;
    how.stage = options_.stage;
    how.ties = options_.ties;
    how.resume = nullptr;
    how.on_stages_done = nullptr;
    auto staged = staged_fit(*options_.start, sequences, how);
    if (!staged) return tl::unexpected(staged.error());
    bool is_done = false;
    const auto plan = plan_stages(*options_.start, sequences, how);
    for (StageRecord& record : staged->stages) {
      std::vector<std::string> terms = all_terms();
      for (const auto& wave : plan)
        for (const StageTask& task : wave)
          if (task.name == record.name) terms = task.terms;
      is_done |= record.done;
      cost_ = record.cost_after;
      record.name = std::string(kStage) + "_" + record.name;
      fit_.stages.push_back(std::move(record));
      fit_.terms.push_back(std::move(terms));
    }
    fit_.stopped = staged->stopped;
    if (is_done) fit_.model = std::move(staged->model);
    return is_done;
  }

  std::vector<std::string> all_terms() const {
    std::vector<std::string> terms;
    for (const model::Term& term : fit_.model.terms) terms.push_back(term.id);
    return terms;
  }

  std::vector<RoleSequence> fitted_sequences() const {
    std::vector<RoleSequence> sequences;
    for (std::size_t s = 0; s < measured_.size(); ++s)
      if (measured_[s].is_fitted)
        sequences.push_back({measured_[s].coarse.role,
                             without_grid_error(measured_[s].coarse.sequence, fit_.errors[s])});
    return sequences;
  }

  /// Of the channels that count, in the frames that both estimates have.
  double change_since(const std::vector<GridError>& before) const {
    double squares = 0.0;
    int rows = 0;
    for (std::size_t s = 0; s < measured_.size(); ++s) {
      if (!measured_[s].is_fitted) continue;
      const Sequence was = as_fitted(s, before[s]), is = as_fitted(s, fit_.errors[s]);
      const Observations channels(is);
      for (std::size_t f = 0; f < is.frames.size(); ++f)
        for (int c = 0; c < channels.count(); ++c) {
          const double change =
              channels.measured(is.frames[f], c) - channels.measured(was.frames[f], c);
          if (std::isnan(change)) continue;
          squares += std::pow(change / channels.sigma(is, c), 2);
          ++rows;
        }
    }
    return rows > 0 ? std::sqrt(squares / rows) : 0.0;
  }

  Sequence as_fitted(std::size_t s, const GridError& error) const {
    const RoleSequence& coarse = measured_[s].coarse;
    return observed({coarse.role, without_grid_error(coarse.sequence, error)},
                    options_.stage.channels);
  }

  const std::vector<OnTwoGrids>& measured_;
  const GridFreeOptions& options_;
  GridFreeFit fit_;
  double cost_ = 0.0;
};

}  // namespace

double order_of(const Sequence& sequence, bool is_laid_for_clips) {
  const bool has_table =
      std::any_of(sequence.boundaries.begin(), sequence.boundaries.end(),
                  [](const mechanics::Boundary& boundary) { return !boundary.held.empty(); });
  if (has_table) return 2.0;
  return is_laid_for_clips ? 1.7 : 1.3;
}

void measure_as(const Sequence& coarse, Sequence& fine) {
  for (std::size_t f = 0; f < std::min(coarse.frames.size(), fine.frames.size()); ++f) {
    fine.frames[f].points_m = coarse.frames[f].points_m;
    fine.frames[f].forces_N = coarse.frames[f].forces_N;
    fine.frames[f].scalars = coarse.frames[f].scalars;
  }
}

Expected<GridFreeFit> grid_free_fit(model::Model model, const std::vector<OnTwoGrids>& measured,
                                    const GridFreeOptions& options) {
  if (options.most_rounds < 1 || !(options.settled_sigmas > 0.0))
    return bad_input(
        "a fit without the grid's error takes a round at least, and ends where its "
        "change is below a number above 0");
  if (std::none_of(measured.begin(), measured.end(),
                   [](const OnTwoGrids& one) { return one.is_fitted; }))
    return bad_input("there is no sequence to fit to without the grid's error");
  return GridFree(measured, options).run(std::move(model));
}

}  // namespace tenter::estimation
