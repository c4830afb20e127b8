// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/stage.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "server/estimation/least_squares/dissipation.h"
#include "server/estimation/staged/resting_frames.h"
#include "server/estimation/staged/splines/knot_choice.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/estimation/staged/splines/strain_histogram.h"
#include "server/estimation/staged/start/constant_guess.h"
#include "server/estimation/staged/unseen.h"

namespace tenter::estimation {
namespace {

/// A model with the parameters that its fit ended with.
struct Fitted {
  model::Model model;
  ParameterTies ties;
  FitResult result;
  std::vector<std::vector<mechanics::State>> states;
  std::vector<std::vector<double>> frame_costs;  ///< as states
};

/// A start whose frames are solved. Refers to the model that it is of.
struct Trial {
  SequenceEvaluator evaluator;
  double cost = 0.0;
};

class Stage {
 public:
  Stage(const StageTask& task, const StageOptions& options, const model::Model& model)
      : task_(task), options_(options) {
    record_.name = task.name;
    for (const RoleSequence& s : task.sequences) {
      const int all = static_cast<int>(s.sequence.frames.size());
      taken_.push_back(
          taken_frames(model, all, options.most_frames > 0 ? options.most_frames : all));
      sequences_.push_back(observed(s, options.channels));
      keep_frames(sequences_.back(), taken_.back());
    }
  }

  Expected<StageRecord> run(model::Model& model) {
    if (task_.sequences.empty() || task_.terms.empty())
      return skip(task_.terms.empty() ? "the model has no term for it" : "there is no sequence");
    model::Model start = with_only_its_terms_free(model);
    begin_with_one_point(
        start, task_.refine && task_.from_one_point ? task_.terms : std::vector<std::string>{});
    auto ties = tie_terms(start, task_.ties);
    if (!ties) return tl::unexpected(ties.error());
    if (auto ok = choose_start(start, *ties); !ok) return tl::unexpected(ok.error());
    if (!record_.message.empty()) return record_;
    if (task_.holds_unseen && are_held(start, task_.terms)) return hold(record_.cost_before);
    auto fitted = fit_curves(start, *ties);
    if (!fitted) return tl::unexpected(fitted.error());
    if (!fitted->result.usable) return skip(fitted->result.message);
    for (int more = 1; more <= 2 && may_refine(*fitted, more);) {
      auto finer = refined(*fitted, more);
      if (!finer) return tl::unexpected(finer.error());
      if (accepts(*finer, *fitted)) {
        fitted = std::move(finer);
        more = 1;
      } else {
        ++more;
      }
    }
    write_back(*fitted, model);
    if (task_.holds_unseen && !is_seen(fitted->model, task_.terms, fitted->result)) {
      hold_at(task_.held_at.value_or(stand_in(model, sequences_.front().cloth.mesh)), task_.terms,
              model);
      auto held = tie_terms(model, task_.ties);
      if (!held) return tl::unexpected(held.error());
      const auto trial = try_at(model, *held, held->values());
      return hold(trial ? trial->cost : record_.cost_after);
    }
    return record_;
  }

 private:
  StageRecord hold(double cost) {
    record_.done = record_.held = true;
    record_.cost_after = cost;
    record_.message = task_.held_at ? "not seen by the data: held at the value given for that"
                                    : "not seen by the data: held at what stands in for it";
    return record_;
  }

  StageRecord skip(std::string why) {
    record_.message = std::move(why);
    return record_;
  }

  static bool holds(const std::vector<std::string>& ids, const model::Term& term) {
    return std::find(ids.begin(), ids.end(), term.id) != ids.end();
  }

  bool is_fitted(const model::Term& term) const {
    return holds(task_.terms, term) || holds(task_.along, term);
  }

  model::Model with_only_its_terms_free(model::Model model) const {
    for (model::Term& term : model.terms)
      for (model::Parameter& p : term.law.parameters) p.fixed |= !is_fitted(term);
    for (model::SensorCorrection& correction : model.corrections)
      for (model::Parameter& p : correction.parameters) p.fixed = true;
    return model;
  }

  bool is_refined(const model::Term& term) const {
    return task_.refine && holds(task_.terms, term) && is_spline(term.law);
  }

  /// Of the values that the stage was given and the guess from forces, those of the lower cost.
  Expected<void> choose_start(model::Model& start, ParameterTies& ties) {
    const Eigen::VectorXd given = ties.values();
    known_ = try_at(start, ties, given);
    if (auto ok = leave_out_restless(start, ties, given); !ok) return ok;
    if (!record_.message.empty()) return {};
    record_.cost_at_start = known_->cost;
    record_.cost_before = improve_start(start, ties, known_->cost, options_.gap);
    record_.guessed = record_.cost_before < record_.cost_at_start;
    return {};
  }

  /// Puts the guess from forces into `ties` where its cost is lower; the cost of what is there
  /// then.
  double improve_start(const model::Model& model, ParameterTies& ties, double cost,
                       const GapOptions& how) {
    if (!options_.first_guess || !task_.guess) return cost;
    std::vector<GapSequence> measured;
    for (std::size_t s = 0; s < sequences_.size(); ++s)
      measured.push_back({&whole(s), rows_of(task_.sequences[s].role, options_.channels)});
    const auto gap = equation_gap(model, ties, measured, how);
    if (!gap) {
      record_.guess_message = gap.error().message;
      return cost;
    }
    Eigen::VectorXd q = gap->q;
    for (std::size_t k = 0; k < ties.free.size(); ++k) {
      double& value = q[static_cast<Eigen::Index>(k)];
      value = started(value, ties.free[k].value, ties.free[k]);
    }
    auto guessed = try_at(model, ties, q);
    if (!guessed || !(guessed->cost < cost)) {
      record_.guess_message = guessed ? "its cost is higher" : "frames have no rest there";
      return cost;
    }
    for (std::size_t k = 0; k < ties.free.size(); ++k)
      ties.free[k].value = q[static_cast<Eigen::Index>(k)];
    known_ = std::move(guessed);
    return known_->cost;
  }

  /// With the points of all sequences, also of those that only forces of are compared, but without
  /// the frames that were left out.
  const Sequence& whole(std::size_t s) {
    if (whole_.empty()) {
      whole_ = sequences_;
      for (std::size_t k = 0; k < whole_.size(); ++k) {
        const Sequence& given = task_.sequences[k].sequence;
        whole_[k].points = given.points;
        for (std::size_t f = 0; f < whole_[k].frames.size(); ++f)
          whole_[k].frames[f].points_m =
              given.frames[static_cast<std::size_t>(taken_[k][f])].points_m;
      }
    }
    return whole_[s];
  }

  /// With the Jacobian: the fit that begins here has its first iteration done.
  std::optional<Trial> try_at(const model::Model& model, const ParameterTies& ties,
                              const Eigen::VectorXd& q) {
    auto evaluator = SequenceEvaluator::make(model, sequences_, evaluator_options(model, ties));
    if (!evaluator) return std::nullopt;
    Eigen::VectorXd residuals;
    RowMatrix jacobian;
    if (evaluator->evaluate(ties.all(q), residuals, &jacobian) != mechanics::PathStatus::ok)
      return std::nullopt;
    record_.rows = evaluator->row_count();
    const Eigen::VectorXd weights = evaluator->weights();
    const double cost =
        weights.size() > 0 ? residuals.cwiseAbs2().dot(weights) : residuals.squaredNorm();
    return Trial{std::move(*evaluator), cost};
  }

  SequenceOptions evaluator_options(const model::Model& model, const ParameterTies& ties) const {
    SequenceOptions options;
    options.starts_are_near = starts_are_rests_;
    for (Eigen::Index p = 0; p < ties.map.rows(); ++p) {
      bool moves = false;
      for (Eigen::Index q = 0; q < ties.map.cols(); ++q)
        moves |= ties.map(p, q) != 0.0 && !ties.free[static_cast<std::size_t>(q)].fixed;
      if (moves) options.moving.push_back(p);
    }
    options.threads = options_.threads;
    options.tolerance_N = options_.tolerance_N;
    options.weighting = options_.weighting;
    if (options_.on_frame)
      options.on_frame = [this, &model](const FrameNote& at) {
        options_.on_frame({record_.name, model, at});
      };
    return options;
  }

  Expected<void> leave_out_restless(const model::Model& model, const ParameterTies& ties,
                                    const Eigen::VectorXd& q) {
    if (known_) return {};
    // an input that does not fit is told from frames without rest
    if (auto made = SequenceEvaluator::make(model, sequences_, evaluator_options(model, ties));
        !made)
      return tl::unexpected(made.error());
    for (std::size_t s = 0; s < sequences_.size(); ++s) {
      auto rest = resting_frames(model, sequences_[s], ties.all(q), options_.tolerance_N);
      if (!rest) return tl::unexpected(rest.error());
      whole(s);
      for (const RestlessFrame& frame : rest->restless)
        record_.dropped.push_back({sequences_[s].name,
                                   taken_[s][static_cast<std::size_t>(frame.frame)] + 1,
                                   frame.reason});
      keep_frames(sequences_[s], rest->resting);
      keep_frames(whole_[s], rest->resting);
    }
    for (const Sequence& sequence : sequences_) {
      if (!sequence.frames.empty()) continue;
      record_.message = "no frame of \"" + sequence.name + "\" has a rest at the start values";
      return {};
    }
    known_ = try_at(model, ties, q);
    if (!known_) record_.message = "the model has no equilibrium at the start values";
    return {};
  }

  Expected<Fitted> fit_curves(const model::Model& model, const ParameterTies& ties) {
    auto evaluator =
        known_ ? Expected<SequenceEvaluator>(std::move(known_->evaluator))
               : SequenceEvaluator::make(model, sequences_, evaluator_options(model, ties));
    known_.reset();
    if (!evaluator) return tl::unexpected(evaluator.error());
    FitOptions options;
    options.method = options_.method;
    options.max_iterations = options_.max_iterations;
    options.tolerance = options_.tolerance;
    options.loss = options_.loss;
    options.friction = friction_places(model);
    const int points = points_of(model);
    if (options_.on_progress)
      options.on_iteration = [&](int iteration, double cost) {
        return options_.on_progress({task_.name, points, iteration, cost});
      };
    Fitted fitted{model, ties, fit_tied(*evaluator, ties, options), evaluator->states(), {}};
    record_.iterations += fitted.result.iterations;
    record_.stopped |= fitted.result.stopped;
    if (!fitted.result.usable) return fitted;
    fitted.frame_costs = frame_costs(fitted.result.residuals, evaluator->rows(), fitted.states);
    record_.refinements.push_back({points, fitted.result.chi2, true});
    store(fitted.result, fitted.model);
    // the next fit starts each frame where this one ended
    for (std::size_t s = 0; s < sequences_.size(); ++s)
      for (std::size_t f = 0; f < sequences_[s].frames.size(); ++f)
        sequences_[s].frames[f].start = fitted.states[s][f];
    starts_are_rests_ = true;
    return fitted;
  }

  int points_of(const model::Model& model) const {
    std::size_t most = 0;
    for (const model::Term& term : model.terms)
      if (holds(task_.terms, term)) most = std::max(most, term.law.parameters.size());
    return static_cast<int>(most);
  }

  bool may_refine(const Fitted& fitted, int more) const {
    if (!task_.refine || record_.stopped) return false;
    const double noise = record_.rows + 2.0 * std::sqrt(2.0 * record_.rows);
    if (options_.stop_at_noise && fitted.result.chi2 <= noise) return false;
    if (points_of(fitted.model) + more > options_.most_points) return false;
    return std::any_of(fitted.model.terms.begin(), fitted.model.terms.end(),
                       [&](const model::Term& term) { return is_refined(term); });
  }

  /// The curves with `more` control points each, fitted. An even curve gains nothing by the second
  /// of its points and all by the third, so two steps are looked at before it is left.
  Expected<Fitted> refined(const Fitted& fitted, int more) {
    model::Model finer = fitted.model;
    if (!has_ranges_)
      if (auto ok = choose_ranges(fitted); !ok) return tl::unexpected(ok.error());
    for (const model::StrainRange& range : ranges_)
      for (model::Term& term : finer.terms)
        if (term.id == range.term)
          std::tie(term.law.range_lo, term.law.range_hi) = std::pair(range.lo, range.hi);
    const auto left = options_.knots_from_data ? strains_of(fitted, true)
                                               : Expected<std::vector<StrainHistogram>>{};
    if (!left) return tl::unexpected(left.error());
    for (std::size_t t = 0; t < finer.terms.size(); ++t) {
      model::Term& term = finer.terms[t];
      if (!is_refined(term)) continue;
      const int points =
          std::min(static_cast<int>(term.law.parameters.size()) + more, options_.most_points);
      auto law = with_points(
          term.law, points,
          left->empty() ? std::vector<double>{} : inner_knots(term.law, points, (*left)[t]));
      if (!law) return tl::unexpected(law.error());
      term.law = std::move(*law);
    }
    const auto ties = tie_terms(finer, task_.ties);
    if (!ties) return tl::unexpected(ties.error());
    return fit_curves(finer, *ties);
  }

  /// Of each term the strains of the frames, of terms of a group those of all; weighted with what
  /// is left of a frame's cost, or each frame alike.
  Expected<std::vector<StrainHistogram>> strains_of(const Fitted& fitted, bool by_cost) {
    const std::vector<model::Term>& terms = fitted.model.terms;
    std::vector<StrainHistogram> own(terms.size());
    for (std::size_t s = 0; s < sequences_.size(); ++s) {
      const auto bound = mechanics::MeshModel::make(fitted.model, sequences_[s].cloth);
      if (!bound) return tl::unexpected(bound.error());
      append(own, strain_histograms(*bound, fitted.states[s],
                                    by_cost ? fitted.frame_costs[s] : std::vector<double>{}));
    }
    merge_tied(terms, task_.ties, own);
    return own;
  }

  /// The strains of the first fit's frames; a range that the document gives stays.
  Expected<void> choose_ranges(const Fitted& fitted) {
    const std::vector<model::Term>& terms = fitted.model.terms;
    const auto strains = strains_of(fitted, false);
    if (!strains) return tl::unexpected(strains.error());
    for (std::size_t t = 0; t < terms.size(); ++t) {
      if (!is_refined(terms[t]) || terms[t].law.range_hi > terms[t].law.range_lo) continue;
      auto [lo, hi] = (*strains)[t].range(options_.outliers);
      if (!(hi > lo)) hi = lo + 1e-6;
      ranges_.push_back({terms[t].id, lo, hi});
    }
    has_ranges_ = true;
    return {};
  }

  bool accepts(const Fitted& finer, const Fitted& before) {
    const bool gains = finer.result.usable &&
                       finer.result.chi2 <= (1.0 - options_.least_gain) * before.result.chi2;
    if (!gains && finer.result.usable) record_.refinements.back().kept = false;
    return gains;
  }

  void write_back(const Fitted& fitted, model::Model& model) {
    record_.done = true;
    record_.converged = fitted.result.converged;
    record_.cost_after = fitted.result.chi2;
    record_.message = record_.stopped ? "stopped" : fitted.result.message;
    const std::vector<std::string> names = parameter_names(fitted.model);
    std::size_t first = 0;
    for (std::size_t t = 0; t < model.terms.size(); ++t) {
      const model::Term& from = fitted.model.terms[t];
      const std::size_t count = from.law.parameters.size();
      if (is_fitted(from)) {
        const bool was_fixed =
            !model.terms[t].law.parameters.empty() && model.terms[t].law.parameters.front().fixed;
        model.terms[t].law = from.law;
        for (model::Parameter& p : model.terms[t].law.parameters) p.fixed = was_fixed;
        for (std::size_t k = 0; k < count; ++k)
          if (fitted.result.states[first + k] != ParameterState::free)
            record_.not_free.push_back({names[first + k], fitted.result.states[first + k]});
      }
      first += count;
    }
    for (const model::StrainRange& range : ranges_) {
      const auto is_same = [&](const model::StrainRange& r) { return r.term == range.term; };
      std::erase_if(model.strain_ranges, is_same);
      model.strain_ranges.push_back(range);
    }
  }

  const StageTask& task_;
  const StageOptions& options_;
  StageRecord record_;
  std::vector<std::vector<int>> taken_;  ///< frames of each given sequence, before any is left out
  std::vector<Sequence> sequences_;      ///< with these and the channels that count
  std::vector<Sequence> whole_;
  std::optional<Trial> known_;     ///< where the next fit begins
  bool starts_are_rests_ = false;  ///< of the last fit
  std::vector<model::StrainRange> ranges_;
  bool has_ranges_ = false;
};

}  // namespace

Expected<StageRecord> fit_stage(model::Model& model, const StageTask& task,
                                const StageOptions& options) {
  return Stage(task, options, model).run(model);
}

}  // namespace tenter::estimation
