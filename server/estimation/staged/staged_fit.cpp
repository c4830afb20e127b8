// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/staged_fit.h"

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <optional>

#include "server/estimation/parallel.h"
#include "server/estimation/staged/start/constant_guess.h"
#include "server/estimation/staged/whole_cost.h"

namespace tenter::estimation {
namespace {

using Groups = std::vector<std::vector<std::string>>;
using Wave = std::vector<StageTask>;

constexpr const char* kCoupled = "coupled";

bool share_a_group(const StageTask& a, const StageTask& b, const Groups& groups) {
  const auto holds = [](const std::vector<std::string>& group, const StageTask& task) {
    const auto is_in_group = [&](const std::string& id) {
      return std::find(group.begin(), group.end(), id) != group.end();
    };
    return std::any_of(task.terms.begin(), task.terms.end(), is_in_group) ||
           std::any_of(task.along.begin(), task.along.end(), is_in_group);
  };
  return std::any_of(groups.begin(), groups.end(), [&](const std::vector<std::string>& group) {
    return holds(group, a) && holds(group, b);
  });
}

/// Stages of a wave that share a curve become one.
Wave merged(Wave wave, const Groups& groups) {
  Wave result;
  for (StageTask& task : wave) {
    const auto same = std::find_if(result.begin(), result.end(), [&](const StageTask& other) {
      return share_a_group(task, other, groups);
    });
    if (same == result.end()) {
      result.push_back(std::move(task));
      continue;
    }
    same->name += "+" + task.name;
    same->terms.insert(same->terms.end(), task.terms.begin(), task.terms.end());
    same->along.insert(same->along.end(), task.along.begin(), task.along.end());
    for (RoleSequence& s : task.sequences) same->sequences.push_back(std::move(s));
  }
  return result;
}

class StagedFit {
 public:
  StagedFit(model::Model model, const std::vector<RoleSequence>& measured,
            const StagedOptions& options)
      : options_(options), whole_(model, measured, options.stage) {
    result_.model = std::move(model);
    if (options.resume != nullptr) result_ = *options.resume;
    done_before_ = result_.stages.size();
  }

  Expected<void> guess(const std::vector<RoleSequence>& measured) {
    if (was_done(1)) return {};
    StageTask task{"first_guess", {}, options_.ties, {}};
    for (const model::Term& term : result_.model.terms) task.terms.push_back(term.id);
    for (const RoleSequence& s : measured)
      if (s.role != Role::evaluation) task.sequences.push_back(s);
    model::Model guessed = result_.model;
    auto record = guess_all(guessed, task, options_.stage);
    if (!record) return tl::unexpected(record.error());
    if (record->done)
      if (auto ok = adopt_guess(std::move(guessed), *record); !ok) return ok;
    result_.stages.push_back(std::move(*record));
    if (options_.on_stages_done) options_.on_stages_done(result_);
    return {};
  }

  Expected<StagedResult> run(const std::vector<Wave>& waves) {
    for (const Wave& wave : waves) {
      if (was_done(wave.size())) continue;
      if (auto ok = take(wave); !ok) return tl::unexpected(ok.error());
      if (result_.stopped) break;
      if (options_.on_stages_done) options_.on_stages_done(result_);
    }
    return std::move(result_);
  }

 private:
  /// Every stage of a wave starts from the same model; then each puts its own terms into it.
  Expected<void> take(const Wave& wave) {
    const auto count = wave.size();
    const int at_once = std::max(1, std::min(options_.stage.threads, static_cast<int>(count)));
    StageOptions options = options_.stage;
    options.threads = std::max(1, options_.stage.threads / at_once);
    options.on_progress = [&](const StageProgress& progress) { return report(progress); };
    const bool is_last = wave.front().name == kCoupled;
    if (options_.coupled && !is_last) {
      options.most_frames = options_.early_frames;
      options.tolerance = std::max(options.tolerance, options_.early_tolerance);
    }
    std::vector<model::Model> models(count, result_.model);
    std::vector<std::optional<Expected<StageRecord>>> records(count);
    in_parallel(at_once, static_cast<int>(count), [&](int, int i) {
      const auto k = static_cast<std::size_t>(i);
      records[k].emplace(fit_stage(models[k], wave[k], options));
    });
    for (std::size_t k = 0; k < count; ++k) {
      if (!*records[k]) return tl::unexpected(records[k]->error());
      StageRecord& record = **records[k];
      result_.stopped |= record.stopped;
      if (record.done)
        if (auto ok = adopt(models[k], wave[k], record); !ok) return tl::unexpected(ok.error());
      result_.stages.push_back(std::move(record));
    }
    return {};
  }

  /// Takes the guess, unless fewer frames have a rest with it: forces that strain noise along a
  /// path can tell a friction so stiff that nothing comes to rest.
  Expected<void> adopt_guess(model::Model guessed, StageRecord& record) {
    auto then = whole_.of(guessed);
    if (!then) return tl::unexpected(then.error());
    if (then->restless() > 0) {
      auto now = whole_.of(result_.model);
      if (!now) return tl::unexpected(now.error());
      if (now->restless() < then->restless()) {
        record.done = false;
        record.message = put_back(*now, *then);
        now_ = std::move(*now);
        return {};
      }
    }
    result_.model = std::move(guessed);
    now_ = std::move(*then);
    return {};
  }

  /// Puts the stage's terms into the model, unless that is worse for the sequences together.
  Expected<void> adopt(const model::Model& from, const StageTask& task, StageRecord& record) {
    model::Model changed = result_.model;
    for (const auto* ids : {&task.terms, &task.along})
      for (const std::string& id : *ids) take_term(from, id, changed);
    if (!now_) {
      auto now = whole_.of(result_.model);
      if (!now) return tl::unexpected(now.error());
      now_ = std::move(*now);
    }
    auto then = whole_.of(changed);
    if (!then) return tl::unexpected(then.error());
    // what is not seen has no better value to go back to, as long as frames rest
    const bool is_worse = record.held ? then->restless() > now_->restless() : then->is_above(*now_);
    if (is_worse) {
      record.done = false;
      record.message = put_back(*now_, *then);
      return {};
    }
    result_.model = std::move(changed);
    now_ = std::move(*then);
    return {};
  }

  static std::string put_back(const WholeCost::Value& before, const WholeCost::Value& after) {
    char words[160];
    if (after.restless() > before.restless())
      std::snprintf(words, sizeof words,
                    "put back: %d frames of all sequences have no rest with it, %d without",
                    after.restless(), before.restless());
    else
      std::snprintf(words, sizeof words,
                    "put back: the cost over all sequences rose from %.4g to %.4g",
                    before.cost(after), after.cost(before));
    return words;
  }

  static void take_term(const model::Model& from, const std::string& id, model::Model& into) {
    for (std::size_t t = 0; t < from.terms.size(); ++t)
      if (from.terms[t].id == id) into.terms[t] = from.terms[t];
    const auto is_of_term = [&](const model::StrainRange& range) { return range.term == id; };
    std::erase_if(into.strain_ranges, is_of_term);
    for (const model::StrainRange& range : from.strain_ranges)
      if (is_of_term(range)) into.strain_ranges.push_back(range);
  }

  /// Whether the next `count` stages are among those of a result that is gone on from.
  bool was_done(std::size_t count) {
    if (done_before_ < count) return false;
    done_before_ -= count;
    return true;
  }

  bool report(const StageProgress& progress) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_stopping_) return false;
    if (options_.stage.on_progress && !options_.stage.on_progress(progress)) is_stopping_ = true;
    return !is_stopping_;
  }

  const StagedOptions& options_;
  StagedResult result_;
  WholeCost whole_;
  std::optional<WholeCost::Value> now_;  ///< of the model as it is
  std::size_t done_before_ = 0;          ///< stages of options_.resume that are still to be passed
  std::mutex mutex_;
  bool is_stopping_ = false;
};

}  // namespace

std::vector<Wave> plan_stages(const model::Model& model, const std::vector<RoleSequence>& measured,
                              const StagedOptions& options) {
  const auto stage = [&](const char* name, Component component, std::vector<Role> roles) {
    StageTask task;
    task.name = name;
    task.terms = terms_of(model, component);
    task.ties = options.ties;
    for (const Role role : roles)
      for (const RoleSequence& s : measured)
        if (s.role == role) task.sequences.push_back(s);
    return task;
  };
  std::vector<Wave> waves = {
      {stage("stretch_u", Component::stretch_u, {Role::stretch_u}),
       stage("stretch_v", Component::stretch_v, {Role::stretch_v})},
      {stage("shear", Component::shear, {Role::shear})},
      {stage("bend_u", Component::bend_u, {Role::bend_u}),
       stage("bend_v", Component::bend_v, {Role::bend_v})},
      {stage("bend_diagonal", Component::bend_diagonal, {Role::bend_u, Role::bend_v})}};
  // springs between nodes two apart bend and stretch: positions alone would leave their pull open
  const auto stretches_too = [&](StageTask& task, Component component, Role role) {
    const auto is_long_spring = [&](const model::Term& term) {
      return term.strain.name.rfind("ring2_", 0) == 0 &&
             std::find(task.terms.begin(), task.terms.end(), term.id) != task.terms.end();
    };
    if (std::none_of(model.terms.begin(), model.terms.end(), is_long_spring)) return;
    task.along = terms_of(model, component);
    for (const RoleSequence& s : measured)
      if (s.role == role) task.sequences.push_back(s);
  };
  stretches_too(waves[2][0], Component::stretch_u, Role::stretch_u);
  stretches_too(waves[2][1], Component::stretch_v, Role::stretch_v);
  stretches_too(waves[3][0], Component::shear, Role::shear);
  const auto is_tied = [&](const std::string& id) {
    return std::any_of(options.ties.begin(), options.ties.end(), [&](const auto& group) {
      return std::find(group.begin(), group.end(), id) != group.end();
    });
  };
  StageTask& diagonal = waves.back().front();
  diagonal.holds_unseen =
      options.hold_unseen && std::none_of(diagonal.terms.begin(), diagonal.terms.end(), is_tied);
  diagonal.held_at = options.held_at;
  for (Wave& wave : waves) wave = merged(std::move(wave), options.ties);
  const std::size_t first_pass = waves.size();
  for (std::size_t w = 1; options.repeat && w < first_pass; ++w) {
    Wave again = waves[w];
    for (StageTask& task : again) {
      task.name += "_again";
      task.from_one_point = task.guess = false;
    }
    waves.push_back(std::move(again));
  }
  if (!options.coupled) return waves;
  StageTask coupled;
  coupled.name = kCoupled;
  coupled.guess = false;
  coupled.ties = options.ties;
  coupled.refine = false;
  for (const model::Term& term : model.terms) coupled.terms.push_back(term.id);
  for (const RoleSequence& s : measured)
    if (s.role != Role::evaluation) coupled.sequences.push_back(s);
  waves.push_back({std::move(coupled)});
  return waves;
}

Expected<StagedResult> staged_fit(model::Model model, const std::vector<RoleSequence>& measured,
                                  const StagedOptions& options) {
  const bool has_data = std::any_of(measured.begin(), measured.end(), [](const RoleSequence& s) {
    return s.role != Role::evaluation;
  });
  if (!has_data) return bad_input("there is no sequence to fit to");
  if (auto ok = without_corrections(model); !ok) return tl::unexpected(ok.error());
  const std::vector<Wave> waves = plan_stages(model, measured, options);
  StagedFit fit(std::move(model), measured, options);
  if (options.stage.first_guess)
    if (auto ok = fit.guess(measured); !ok) return tl::unexpected(ok.error());
  return fit.run(waves);
}

}  // namespace tenter::estimation
