// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/diagnose.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <utility>

#include "server/diagnosis/backward.h"
#include "server/diagnosis/beginning.h"
#include "server/diagnosis/checks/checklist.h"
#include "server/diagnosis/checks/lattice.h"
#include "server/diagnosis/checks/refined_solve.h"
#include "server/diagnosis/checks/repeats_check.h"
#include "server/diagnosis/prepare.h"
#include "server/diagnosis/screening/shortlist.h"
#include "server/diagnosis/take_apart.h"
#include "server/diagnosis/trials/at_rest.h"
#include "server/diagnosis/trials/exchange.h"
#include "server/diagnosis/trials/gain.h"
#include "server/diagnosis/trials/model_edit.h"
#include "server/diagnosis/verdicts/score.h"
#include "server/diagnosis/verdicts/standing.h"
#include "server/diagnosis/verdicts/verdict_words.h"
#include "server/diagnosis/verdicts/verdicts.h"

namespace tenter::diagnosis {
namespace {

/// Runs task(0..count-1) on some threads; results are placed by index, so their order is that of
/// the tasks.
void parallel(int threads, int count, const std::function<void(int)>& task) {
  if (threads <= 1 || count <= 1) {
    for (int i = 0; i < count; ++i) task(i);
    return;
  }
  std::atomic<int> next = 0;
  std::vector<std::jthread> pool;
  pool.reserve(static_cast<std::size_t>(threads));
  for (int t = 0; t < std::min(threads, count); ++t)
    pool.emplace_back([&] {
      for (int i = next++; i < count; i = next++) task(i);
    });
}

/// Refits the short list and judges it, best first, until one passes every gate. Trials keep the
/// order of their criterion; the first of those that passed is the round's choice.
std::vector<Trial> run_round(const std::vector<Candidate>& candidates, const Reference& current,
                             Diagnosis& d, int added_effects, const Control& control) {
  std::vector<Trial> trials(candidates.size());
  parallel(control.threads, static_cast<int>(candidates.size()), [&](int i) {
    if (control.stop.stop_requested()) return;
    trials[static_cast<std::size_t>(i)] =
        refit(candidates[static_cast<std::size_t>(i)], current, d.data);
  });
  std::erase_if(trials, [&](const Trial& t) {
    if (!t.fit.usable && t.effect != nullptr)
      d.path.push_back(step_of("reject", t.effect->id,
                               t.variant.words + ": the refit failed: " + t.fit.message, current,
                               d));
    return !t.fit.usable;
  });
  double rows = current.fit.effective_rows;
  for (const Trial& t : trials) rows = std::max(rows, t.fit.effective_rows);
  std::stable_sort(trials.begin(), trials.end(), [&](const Trial& a, const Trial& b) {
    return criterion_of(a, added_effects + 1, rows) < criterion_of(b, added_effects + 1, rows);
  });
  return trials;
}

/// Forward: one effect at a time, the best that passes, until none does.
void go_forward(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted,
                const Request& request, const Excitation& excitation, const Control& control) {
  // rounding follows the path of the force, and a little of it looks like anything
  constexpr double kLeastOfSteps = 0.2;
  const double steps = chi2_of_steps(d, 0.0);
  for (int round = static_cast<int>(accepted.size()); round < request.options.max_effects;
       ++round) {
    const double fraction = 0.1 + 0.7 * round / request.options.max_effects;
    d.unproven.clear();
    d.within_form.clear();
    control.report(
        {"screen", "round " + std::to_string(round + 1), round, current.fit.chi2, fraction});
    ScreenOptions options;
    options.null_twins = request.options.null_twins;
    options.seed = request.options.seed + static_cast<unsigned long long>(round);
    options.effects = request.options.effects;
    const Screen found = screen(current.model, current.fit, d.data, d.noise, excitation, options);
    if (round == 0) d.first_screen = found;
    const std::vector<Candidate> candidates = shortlist(found, current.fit, 5);
    if (candidates.empty() || control.stop.stop_requested()) break;
    std::vector<std::string> added;
    added.reserve(accepted.size());
    for (const Accepted& entry : accepted) added.push_back(entry.trial.effect->id);
    const double error = score_of(*d.data, d.data->rows(), current.fit.residuals, -1).error;
    control.report(
        {"refit", standing(found, added, error), round, current.fit.chi2, fraction + 0.03});
    std::vector<Trial> trials =
        run_round(candidates, current, d, static_cast<int>(accepted.size()), control);
    std::size_t chosen = trials.size();
    for (std::size_t i = 0; i < trials.size() && chosen == trials.size(); ++i) {
      if (control.stop.stop_requested()) break;
      control.report({"gates", trials[i].effect->id + ", " + trials[i].variant.words, round,
                      trials[i].fit.chi2, fraction + 0.06});
      judge(trials[i], current, d.data, found.expected_chi2);
      if (current.fit.chi2 - trials[i].fit.chi2 < kLeastOfSteps * steps)
        trials[i].objections.push_back("the steps of the readings are much larger");
      if (std::string why = objection_of_form(trials[i], current, accepted, d); !why.empty()) {
        if (trials[i].objections.empty()) d.within_form.push_back(trials[i]);
        trials[i].objections.push_back(std::move(why));
      }
      if (trials[i].objections.empty()) {
        chosen = i;
      } else {
        if (lacks_only_proof(trials[i])) d.unproven.push_back(trials[i]);
        PathStep step = step_of("reject", trials[i].effect->id,
                                trials[i].variant.words + ": " + trials[i].objections.front(),
                                reference_of(trials[i]), d);
        step.p_value = trials[i].p_value;
        d.path.push_back(std::move(step));
      }
    }
    if (chosen == trials.size()) break;
    Accepted entry = added_to(current, trials[chosen], d);
    for (std::size_t i = 0; i < trials.size(); ++i)
      if (i != chosen && trials[i].effect != entry.trial.effect &&
          objection_at_rest(trials[i], d.data).empty())
        entry.rivals.push_back(trials[i]);
    current = reference_of(entry.trial);
    PathStep step = step_of("add", entry.trial.effect->id, entry.trial.variant.words, current, d);
    step.p_value = entry.trial.p_value;
    if (entry.trial.held_out_residuals.size() > 0)
      step.held_out = score_of(*d.data, d.data->rows(), entry.trial.held_out_residuals, -1).error;
    d.path.push_back(std::move(step));
    accepted.push_back(std::move(entry));
  }
}

/// Each effect against those that might stand in its place, now that the others are there too.
void exchange(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted,
              const Request& request, const Excitation& excitation, const Control& control) {
  if (accepted.size() < 2) return;
  const ScreenOptions options = {request.options.null_twins, request.options.seed + 31, false,
                                 request.options.effects};
  for (std::size_t i = 0; i < accepted.size() && !control.stop.stop_requested(); ++i) {
    const Effect& effect = *accepted[i].trial.effect;
    control.report({"exchange", effect.id, static_cast<int>(i), current.fit.chi2, 0.82});
    auto reduced = make_reference(without(current.model, effect.id, d.baseline.model), d.data, {});
    if (!reduced) {
      could_not_refit_without(d, effect.id, reduced.error());
      continue;
    }
    auto better = better_in_place_of(effect, d, *reduced, current, excitation, options);
    if (!better) continue;
    Accepted entry = added_to(*reduced, std::move(*better), d);
    entry.rivals = {accepted[i].trial};
    current = reference_of(entry.trial);
    d.path.push_back(step_of("drop", effect.id,
                             entry.trial.effect->id + " does better in its place", current, d));
    d.path.push_back(step_of("add", entry.trial.effect->id, entry.trial.variant.words, current, d));
    const std::string gone = effect.id;
    accepted[i] = std::move(entry);
    std::erase_if(accepted, [&](const Accepted& other) { return other.trial.effect->id == gone; });
  }
}

/// Once more for the extended model; true where a better optimum took its place: one that also
/// predicts what it did not see at least as well.
bool refine_extended(Diagnosis& d, Reference& current, const Request& request,
                     const Control& control) {
  const auto keep_on = [&] { return !control.stop.stop_requested(); };
  RefinedSolve solve =
      refined_solve(current, d.data, whole_data(d, d.outliers), request.options.seed + 7, keep_on);
  if (solve.better &&
      !predicts_as_well(*solve.better, current, d.baseline, d.data, request.options.leave_out)) {
    solve.better.reset();
    solve.overfits = true;
  }
  check_refined_solve(d, solve, "the extended model");
  if (!solve.better) return false;
  current = std::move(*solve.better);
  return true;
}

/// Forward and backward, and once more from a better optimum.
void find_path(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted,
               const Request& request, const Excitation& excitation, const Control& control) {
  go_forward(d, current, accepted, request, excitation, control);
  if (control.stop.stop_requested()) return;
  go_backward(d, current, accepted);
  exchange(d, current, accepted, request, excitation, control);
  take_apart(
      d, current, accepted, excitation,
      {request.options.null_twins, request.options.seed + 57, false, request.options.effects},
      control);
  if (!accepted.empty() && refine_extended(d, current, request, control)) {
    go_forward(d, current, accepted, request, excitation, control);
    go_backward(d, current, accepted);
  }
}

}  // namespace

Expected<Diagnosis> fit_only(const Request& request, const Control& control) {
  auto d = begin(request, control);
  if (!d) return d;
  d->extended = d->baseline;
  measure_gain(*d, request.options, control);
  check(*d);
  return d;
}

Expected<Diagnosis> diagnose(const Request& asked, const Control& control) {
  Request request = asked;
  auto started = begin_refined(request, control);
  if (!started) return started;
  Diagnosis& d = *started;
  const Excitation excitation = examine(d.data->curves);
  report_repeats(d, check_repeats(d.baseline, d.data, d.noise, excitation, request.options.seed));
  Reference current = d.baseline;
  std::vector<Accepted> accepted;
  find_path(d, current, accepted, request, excitation, control);
  if (begin_anew(d, current, accepted, request)) {
    const Reference first = std::exchange(current, d.baseline);
    std::vector<Accepted> found = std::exchange(accepted, {});
    find_path(d, current, accepted, request, excitation, control);
    keep_better_path(d, first, std::move(found), current, accepted);
  }
  if (control.stop.stop_requested())
    return fail(ErrorKind::cancelled, "stopped while effects were being tried");
  const auto look_again = [&] {
    d.extended = current;
    d.last_screen = screen(
        current.model, current.fit, d.data, d.noise, excitation,
        {request.options.null_twins, request.options.seed + 99, false, request.options.effects});
  };
  look_again();
  // without stand-ins more is unexplained, and more is asked of the names that are left
  for (std::size_t found = accepted.size() + 1; accepted.size() < found;) {
    found = accepted.size();
    drop_stand_ins(d, current, accepted);
    drop_series(d, current, accepted);
    if (accepted.size() < found) look_again();
  }
  confirm_outliers(d);
  d.extended.model.name = request.model.name + (accepted.empty() ? "" : ", extended");
  model::Lineage lineage;
  lineage.parent = request.model.name;
  for (const Accepted& entry : accepted) lineage.added.push_back(entry.trial.effect->id);
  for (const auto& [id, capture] : request.captures) lineage.captures.push_back(id);
  d.extended.model.lineage = lineage;
  measure_gain(d, request.options, control);

  std::vector<Finding> findings;
  findings.reserve(accepted.size());
  for (Accepted& entry : accepted)
    findings.push_back({std::move(entry.trial), std::move(entry.rivals)});
  control.report({"verdicts", "", 0, d.extended.fit.chi2, 0.95});
  pass_verdicts(d, findings, excitation, request.options);
  check(d);
  return started;
}

}  // namespace tenter::diagnosis
