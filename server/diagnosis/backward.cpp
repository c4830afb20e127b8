// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/backward.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "server/diagnosis/prepare.h"
#include "server/diagnosis/trials/model_edit.h"
#include "server/diagnosis/verdicts/path.h"
#include "server/diagnosis/verdicts/score.h"
#include "server/diagnosis/verdicts/verdict_words.h"
#include "server/diagnosis/verdicts/verdicts.h"

namespace tenter::diagnosis {
namespace {

std::set<std::string> effects_of(const std::vector<Accepted>& accepted) {
  std::set<std::string> ids;
  for (const Accepted& entry : accepted) ids.insert(entry.trial.effect->id);
  return ids;
}

/// Takes an effect out, refits, and keeps it out where `is_needless` says so of the refit.
template <class Needless>
void drop_where(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted,
                Needless&& is_needless) {
  for (const std::string& id : effects_of(accepted)) {
    auto reduced = make_reference(without(current.model, id, d.baseline.model), d.data, {});
    if (!reduced) {
      could_not_refit_without(d, id, reduced.error());
      continue;
    }
    const std::string why = is_needless(id, *reduced, current);
    if (why.empty()) continue;
    current = std::move(*reduced);
    std::erase_if(accepted, [&](const Accepted& entry) { return entry.trial.effect->id == id; });
    d.path.push_back(step_of("drop", id, why, current, d));
  }
}

/// chi2 that is less after than before, of stresses and of stretches.
std::array<double, 2> gained(const estimation::FitResult& before,
                             const estimation::FitResult& after, const estimation::DataSet& data) {
  const Eigen::VectorXd gain = before.residuals.cwiseAbs2() - after.residuals.cwiseAbs2();
  std::array<double, 2> sum = {0.0, 0.0};
  Eigen::Index r = 0;
  for (const estimation::Row& row : data.rows()) {
    const auto& channels = data.curves[static_cast<std::size_t>(row.curve)].channels;
    const bool is_stress = channels[static_cast<std::size_t>(row.channel)].is_stress;
    sum[is_stress ? 0 : 1] += gain[r++];
  }
  return sum;
}

}  // namespace

Accepted added_to(const Reference& before, Trial trial, const Diagnosis& d) {
  Accepted entry;
  entry.before_chi2 = before.fit.chi2;
  entry.taken = gained(before.fit, trial.fit, *d.data);
  entry.trial = std::move(trial);
  return entry;
}

std::string objection_of_form(const Trial& trial, const Reference& current,
                              const std::vector<Accepted>& accepted, const Diagnosis& d) {
  constexpr double kAll = 0.9;   // of what is missed,
  constexpr double kMuch = 1.2;  // where that is more than the noise by so much
  std::array<double, 2> taken = {0.0, 0.0};
  for (const Accepted& entry : accepted) {
    if (entry.trial.effect == trial.effect) return "";  // more of one
    for (const std::size_t kind : {0UL, 1UL})
      if (!entry.trial.effect->is_exact) taken[kind] += entry.taken[kind];
  }
  const double noise = noise_chi2(d);
  if (trial.effect->is_exact && current.fit.chi2 > kMuch * noise &&
      explained_share(current.fit.chi2, trial.fit.chi2, noise) > kAll)
    return "";
  const std::array<double, 2> gain = gained(current.fit, trial.fit, *d.data);
  const std::size_t shown = gain[0] > gain[1] ? 0 : 1;
  return is_within_form(gain[shown], taken[shown], kFormOfCurves)
             ? "it is no more than the form of what was found may miss"
             : "";
}

PathStep step_of(const std::string& action, const std::string& effect, const std::string& why,
                 const Reference& at, const Diagnosis& d) {
  return path_step(action, effect, why, at,
                   score_of(*d.data, d.data->rows(), at.fit.residuals, -1).error);
}

void could_not_refit_without(Diagnosis& d, const std::string& id, const Error& error) {
  d.checklist.push_back({"WARNING",
                         "the model without " + id + " could not be fitted; it was not asked again",
                         error.message});
}

namespace {

/// Effects of which nothing is left that is their own, now that others are there too, are what they
/// are without that.
void put_in_plain_form(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted) {
  for (const std::string& id : effects_of(accepted)) {
    const Effect& effect = *find_effect(id);
    const auto model = in_plain_form(current, effect);
    auto plain = model ? make_reference(*model, d.data, {}) : tl::unexpected(Error{});
    if (!plain || made_needless(*plain, current).empty()) continue;
    current = std::move(*plain);
    for (Accepted& entry : accepted)
      if (entry.trial.effect->id == id) entry.trial.effect = find_effect(effect.plain_form);
    d.path.push_back(step_of("drop", id, kPlainIsEnough, current, d));
    d.path.push_back(step_of("add", effect.plain_form, "in its place", current, d));
  }
}

}  // namespace

void go_backward(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted) {
  put_in_plain_form(d, current, accepted);
  if (accepted.size() < 2) return;
  drop_where(d, current, accepted,
             [](const std::string&, const Reference& reduced, const Reference& whole) {
               return made_needless(reduced, whole);
             });
}

void drop_stand_ins(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted) {
  if (!misses_more_than_noise(d, d.extended.fit)) return;
  const double missed = d.baseline.fit.chi2 - noise_chi2(d);
  const double unexplained = missed > 0.0 ? (d.extended.fit.chi2 - noise_chi2(d)) / missed : 0.0;
  std::map<std::string, double> best;
  for (const Accepted& entry : accepted) {
    double& share = best[entry.trial.effect->id];
    share =
        std::max(share, explained_share(entry.before_chi2, entry.trial.fit.chi2, noise_chi2(d)));
  }
  drop_where(d, current, accepted, [&](const std::string& id, const Reference&, const Reference&) {
    return stands_in(best[id], unexplained);
  });
}

void drop_series(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted) {
  const std::set<std::string> ids = effects_of(accepted);
  const auto first = std::find_if(d.path.begin(), d.path.end(),
                                  [](const PathStep& s) { return s.action == "add"; });
  if (first == d.path.end()) return;
  const double share = explained_share(d.baseline.fit.chi2, first->chi2, current.fit.chi2);
  if (!is_a_series(static_cast<int>(ids.size()), share)) return;
  current = d.baseline;
  accepted.clear();
  for (const std::string& id : ids)
    d.path.push_back(step_of("drop", id,
                             "of " + std::to_string(ids.size()) + " effects the first explains " +
                                 in_percent(share) +
                                 " of what all explain: terms of a series, no causes",
                             current, d));
}

void keep_better_path(Diagnosis& d, const Reference& first, std::vector<Accepted> found,
                      Reference& current, std::vector<Accepted>& accepted) {
  std::vector<std::string> order;  // of the effects, as they were found
  for (const Accepted& entry : found)
    if (std::find(order.begin(), order.end(), entry.trial.effect->id) == order.end())
      order.push_back(entry.trial.effect->id);
  std::vector<Reference> steps;
  for (std::size_t i = 0; i < order.size(); ++i) {
    model::Model model = first.model;
    for (std::size_t later = i + 1; later < order.size(); ++later)
      model = without(model, order[later], d.baseline.model);
    auto step = make_reference(model, d.data, {});
    if (!step) return;
    steps.push_back(std::move(*step));
  }
  if (steps.empty()) return;
  const double rows = std::max(steps.back().fit.effective_rows, current.fit.effective_rows);
  const auto criterion = [&](const Reference& at, std::size_t effects) {
    return information(at.fit.chi2, free_count(at.model), static_cast<int>(effects), rows);
  };
  if (criterion(steps.back(), order.size()) >= criterion(current, effects_of(accepted).size()))
    return;
  d.path.resize(1);  // the start
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (Accepted& entry : found) {
      if (entry.trial.effect->id != order[i]) continue;
      Trial trial = std::move(entry.trial);
      trial.model = steps[i].model;
      trial.fit = steps[i].fit;
      trial.block_chi2 = steps[i].block_chi2;
      std::vector<Trial> rivals = std::move(entry.rivals);
      entry = added_to(i == 0 ? d.baseline : steps[i - 1], std::move(trial), d);
      entry.rivals = std::move(rivals);
    }
    d.path.push_back(step_of("add", order[i], "as found before", steps[i], d));
  }
  current = std::move(steps.back());
  accepted = std::move(found);
}

}  // namespace tenter::diagnosis
