// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/stage.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "server/estimation/staged/resting_frames.h"
#include "server/estimation/staged/splines/spline_refinement.h"
#include "server/estimation/staged/splines/strain_histogram.h"

namespace tenter::estimation {
namespace {

/// A model with the parameters that its fit ended with.
struct Fitted {
  model::Model model;
  ParameterTies ties;
  FitResult result;
  std::vector<std::vector<mechanics::State>> states;
};

/// A guess for `before`, not at zero where it was not: without any stiffness a curve can hide that
/// it is needed, and frames may have no rest.
double started(double guess, double before, const model::Parameter& p) {
  constexpr double kLeast = 0.1;
  const bool is_stiffness = p.lower && *p.lower >= 0.0 && before > 0.0;
  return is_stiffness ? std::max(guess, kLeast * before) : guess;
}

class Stage {
 public:
  Stage(const StageTask& task, const StageOptions& options) : task_(task), options_(options) {
    record_.name = task.name;
    for (const RoleSequence& s : task.sequences)
      sequences_.push_back(observed(s, options.channels));
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
    return record_;
  }

 private:
  StageRecord skip(std::string why) {
    record_.message = std::move(why);
    return record_;
  }

  bool is_fitted(const model::Term& term) const {
    return std::find(task_.terms.begin(), task_.terms.end(), term.id) != task_.terms.end();
  }

  model::Model with_only_its_terms_free(model::Model model) const {
    for (model::Term& term : model.terms)
      for (model::Parameter& p : term.law.parameters) p.fixed |= !is_fitted(term);
    for (model::SensorCorrection& correction : model.corrections)
      for (model::Parameter& p : correction.parameters) p.fixed = true;
    return model;
  }

  bool is_refined(const model::Term& term) const {
    return task_.refine && is_fitted(term) && is_spline(term.law);
  }

  /// Of the values that the stage was given and the guess from forces, those of the lower cost.
  Expected<void> choose_start(model::Model& start, ParameterTies& ties) {
    const Eigen::VectorXd given = ties.values();
    std::optional<double> cost = cost_at(start, ties, given);
    if (auto ok = leave_out_restless(start, ties, given, cost); !ok) return ok;
    if (!record_.message.empty()) return {};
    record_.cost_at_start = *cost;
    record_.cost_before = improve_start(start, ties, *cost);
    record_.guessed = record_.cost_before < record_.cost_at_start;
    return {};
  }

  /// Puts the guess from forces into `ties` where its cost is lower; the cost of what is there
  /// then.
  double improve_start(const model::Model& model, ParameterTies& ties, double cost) {
    if (!options_.first_guess) return cost;
    std::vector<GapSequence> measured;
    for (std::size_t s = 0; s < sequences_.size(); ++s)
      measured.push_back({&whole(s), rows_of(task_.sequences[s].role, options_.channels)});
    const auto gap = equation_gap(model, ties, measured, options_.gap);
    if (!gap) {
      record_.guess_message = gap.error().message;
      return cost;
    }
    Eigen::VectorXd q = gap->q;
    for (std::size_t k = 0; k < ties.free.size(); ++k) {
      double& value = q[static_cast<Eigen::Index>(k)];
      value = started(value, ties.free[k].value, ties.free[k]);
    }
    const auto guessed = cost_at(model, ties, q);
    if (!guessed || !(*guessed < cost)) {
      record_.guess_message = guessed ? "its cost is higher" : "frames have no rest there";
      return cost;
    }
    for (std::size_t k = 0; k < ties.free.size(); ++k)
      ties.free[k].value = q[static_cast<Eigen::Index>(k)];
    return *guessed;
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
          whole_[k].frames[f].points_m = given.frames[f].points_m;
      }
    }
    return whole_[s];
  }

  std::optional<double> cost_at(const model::Model& model, const ParameterTies& ties,
                                const Eigen::VectorXd& q) {
    auto evaluator = SequenceEvaluator::make(model, sequences_, evaluator_options(model));
    if (!evaluator) return std::nullopt;
    Eigen::VectorXd residuals;
    if (evaluator->evaluate(ties.all(q), residuals, nullptr) != mechanics::PathStatus::ok)
      return std::nullopt;
    record_.rows = evaluator->row_count();
    const Eigen::VectorXd weights = evaluator->weights();
    return weights.size() > 0 ? residuals.cwiseAbs2().dot(weights) : residuals.squaredNorm();
  }

  SequenceOptions evaluator_options(const model::Model& model) const {
    SequenceOptions options;
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
                                    const Eigen::VectorXd& q, std::optional<double>& cost) {
    if (cost) return {};
    // an input that does not fit is told from frames without rest
    if (auto made = SequenceEvaluator::make(model, sequences_, evaluator_options(model)); !made)
      return tl::unexpected(made.error());
    for (std::size_t s = 0; s < sequences_.size(); ++s) {
      auto rest = resting_frames(model, sequences_[s], ties.all(q), options_.tolerance_N);
      if (!rest) return tl::unexpected(rest.error());
      whole(s);
      for (const RestlessFrame& frame : rest->restless)
        record_.dropped.push_back({sequences_[s].name, frame.frame + 1, frame.reason});
      keep_frames(sequences_[s], rest->resting);
      keep_frames(whole_[s], rest->resting);
    }
    for (const Sequence& sequence : sequences_) {
      if (!sequence.frames.empty()) continue;
      record_.message = "no frame of \"" + sequence.name + "\" has a rest at the start values";
      return {};
    }
    cost = cost_at(model, ties, q);
    if (!cost) record_.message = "the model has no equilibrium at the start values";
    return {};
  }

  Expected<Fitted> fit_curves(const model::Model& model, const ParameterTies& ties) {
    auto evaluator = SequenceEvaluator::make(model, sequences_, evaluator_options(model));
    if (!evaluator) return tl::unexpected(evaluator.error());
    FitOptions options;
    options.max_iterations = options_.max_iterations;
    options.tolerance = options_.tolerance;
    options.loss = options_.loss;
    const int points = points_of(model);
    if (options_.on_progress)
      options.on_iteration = [&](int iteration, double cost) {
        return options_.on_progress({task_.name, points, iteration, cost});
      };
    Fitted fitted{model, ties, fit_tied(*evaluator, ties, options), evaluator->states()};
    record_.iterations += fitted.result.iterations;
    record_.stopped |= fitted.result.stopped;
    if (!fitted.result.usable) return fitted;
    record_.refinements.push_back({points, fitted.result.chi2, true});
    store(fitted.result, fitted.model);
    // the next fit starts each frame where this one ended
    for (std::size_t s = 0; s < sequences_.size(); ++s)
      for (std::size_t f = 0; f < sequences_[s].frames.size(); ++f)
        sequences_[s].frames[f].start = fitted.states[s][f];
    return fitted;
  }

  int points_of(const model::Model& model) const {
    std::size_t most = 0;
    for (const model::Term& term : model.terms)
      if (is_fitted(term)) most = std::max(most, term.law.parameters.size());
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
    for (model::Term& term : finer.terms) {
      if (!is_refined(term)) continue;
      const int points = static_cast<int>(term.law.parameters.size()) + more;
      auto law = with_points(term.law, std::min(points, options_.most_points));
      if (!law) return tl::unexpected(law.error());
      term.law = std::move(*law);
    }
    auto ties = tie_terms(finer, task_.ties);
    if (!ties) return tl::unexpected(ties.error());
    improve_start(finer, *ties, fitted.result.chi2);
    return fit_curves(finer, *ties);
  }

  /// The strains of the first fit's frames, terms of a group together; a range that the document
  /// gives stays.
  Expected<void> choose_ranges(const Fitted& fitted) {
    const std::vector<model::Term>& terms = fitted.model.terms;
    std::vector<StrainHistogram> histograms(terms.size());
    for (std::size_t s = 0; s < sequences_.size(); ++s) {
      const auto bound = mechanics::MeshModel::make(fitted.model, sequences_[s].cloth);
      if (!bound) return tl::unexpected(bound.error());
      append(histograms, strain_histograms(*bound, fitted.states[s]));
    }
    for (std::size_t t = 0; t < terms.size(); ++t) {
      if (!is_refined(terms[t]) || terms[t].law.range_hi > terms[t].law.range_lo) continue;
      StrainHistogram all = histograms[t];
      for (const auto& group : task_.ties) {
        const auto holds = [&](const model::Term& term) {
          return std::find(group.begin(), group.end(), term.id) != group.end();
        };
        for (std::size_t other = 0; holds(terms[t]) && other < terms.size(); ++other)
          if (other != t && holds(terms[other])) all.merge(histograms[other]);
      }
      auto [lo, hi] = all.range(options_.outliers);
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
  std::vector<Sequence> sequences_;  ///< with the channels that count
  std::vector<Sequence> whole_;
  std::vector<model::StrainRange> ranges_;
  bool has_ranges_ = false;
};

}  // namespace

void begin_with_one_point(model::Model& model, const std::vector<std::string>& terms) {
  for (model::Term& term : model.terms) {
    const bool has_range = term.law.range_hi > term.law.range_lo;
    const bool is_named = std::find(terms.begin(), terms.end(), term.id) != terms.end();
    if (is_spline(term.law) && (is_named || !has_range)) term.law = as_constant(term.law);
  }
}

Expected<StageRecord> guess_all(model::Model& model, const StageTask& task,
                                const StageOptions& options) {
  StageRecord record;
  record.name = task.name;
  begin_with_one_point(model, task.terms);
  auto ties = tie_terms(model, task.ties);
  if (!ties) return tl::unexpected(ties.error());
  std::vector<GapSequence> measured;
  measured.reserve(task.sequences.size());
  for (const RoleSequence& s : task.sequences) measured.push_back({&s.sequence, GapRows::all});
  const auto gap = equation_gap(model, *ties, measured, options.gap);
  if (!gap) {
    if (gap.error().kind != ErrorKind::refused) return tl::unexpected(gap.error());
    record.message = gap.error().message;
    return record;
  }
  record.done = record.guessed = true;
  record.message = std::to_string(gap->frames) + " frames, " + std::to_string(gap->rounds) +
                   " rounds, " + std::to_string(gap->frames_left_out) + " frames left out";
  const Eigen::VectorXd all = ties->all(gap->q);
  const auto parameters = parameters_of(model);
  const std::vector<std::string> names = parameter_names(model);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    parameters[k]->value =
        started(all[static_cast<Eigen::Index>(k)], parameters[k]->value, *parameters[k]);
    for (Eigen::Index q = 0; q < ties->map.cols(); ++q)
      if (ties->map(static_cast<Eigen::Index>(k), q) != 0.0 &&
          gap->is_at_bound[static_cast<std::size_t>(q)])
        record.not_free.push_back({names[k], ParameterState::at_bound});
  }
  return record;
}

Expected<StageRecord> fit_stage(model::Model& model, const StageTask& task,
                                const StageOptions& options) {
  return Stage(task, options).run(model);
}

}  // namespace tenter::estimation
