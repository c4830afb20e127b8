// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/diagnose_sheet.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "server/diagnosis/field/field_gain.h"
#include "server/diagnosis/field/field_verdicts.h"
#include "server/diagnosis/field/grid_check.h"
#include "server/diagnosis/field/prepare_sheet.h"
#include "server/diagnosis/field/screen/field_screen.h"
#include "server/diagnosis/screening/score_test.h"
#include "server/diagnosis/screening/shortlist.h"
#include "server/diagnosis/trials/model_edit.h"
#include "server/diagnosis/verdicts/path.h"
#include "server/diagnosis/verdicts/standing.h"
#include "server/diagnosis/verdicts/verdict_words.h"
#include "server/estimation/parallel.h"

namespace tenter::diagnosis {
namespace {

/// What the rounds change: the model so far and what was taken into it.
struct Chain {
  const SheetRequest& request;
  const Control& control;
  SheetDiagnosis& d;
  FieldFit current;
  FieldFit held_out;  ///< of the current model
  std::vector<FieldFinding> accepted;

  bool stopped() const { return control.stop.stop_requested(); }
  HeldOutSheets held_out_sheets() const {
    return {d.held_out.sequences.empty() ? nullptr : &d.held_out, held_out};
  }
};

PathStep step_of(const std::string& action, const std::string& effect, const std::string& why,
                 const FieldFit& at, const SheetDiagnosis& d) {
  return path_step(action, effect, why, at.at, score_of_forces(d.data, at).error);
}

std::string standing_of(const Screen& found, const Chain& chain) {
  std::vector<std::string> added;
  added.reserve(chain.accepted.size());
  for (const FieldFinding& finding : chain.accepted) added.push_back(finding.trial.effect->id);
  return standing(found, added, score_of_forces(chain.d.data, chain.current).error);
}

void take(Chain& chain, const FieldTrial& trial) {
  chain.current = {{trial.trial.model, trial.trial.fit, trial.trial.block_chi2},
                   trial.states,
                   chain.current.rows};
  if (chain.d.held_out.sequences.empty()) return;
  auto foretold = predict_field(chain.current.at.model, chain.d.held_out, chain.held_out.states,
                                field_options(chain.control));
  if (foretold) chain.held_out = std::move(*foretold);
}

std::set<std::string> effects_of(const Chain& chain) {
  std::set<std::string> ids;
  for (const FieldFinding& f : chain.accepted) ids.insert(f.trial.effect->id);
  return ids;
}

/// Refits the short list, each trial in a thread of its own; best first.
std::vector<FieldTrial> refit_all(const std::vector<Candidate>& candidates, const Chain& chain) {
  std::vector<FieldTrial> trials(candidates.size());
  FieldFitOptions options = field_options(chain.control);
  options.threads = 1;
  estimation::in_parallel(
      chain.control.threads, static_cast<int>(candidates.size()), [&](int, int i) {
        if (chain.stopped()) return;
        const auto k = static_cast<std::size_t>(i);
        trials[k] = refit_field(candidates[k], chain.current, chain.d.data, options);
      });
  std::erase_if(trials, [](const FieldTrial& t) { return !t.trial.fit.usable; });
  double rows = chain.current.at.fit.effective_rows;
  for (const FieldTrial& t : trials) rows = std::max(rows, t.trial.fit.effective_rows);
  const std::set<std::string> known = effects_of(chain);
  // more of what was found is no further cause
  const auto criterion = [&](const FieldTrial& t) {
    const std::size_t causes = known.size() + (known.contains(t.trial.effect->id) ? 0 : 1);
    return criterion_of(t.trial, static_cast<int>(causes), rows);
  };
  std::stable_sort(trials.begin(), trials.end(), [&](const FieldTrial& a, const FieldTrial& b) {
    return criterion(a) < criterion(b);
  });
  return trials;
}

/// A refit of a sheet costs: of each effect the best few, and none that the screen expects to
/// explain less than half of what the best does.
std::vector<Candidate> worth_a_refit(const Screen& screen, const estimation::FitResult& fit) {
  constexpr std::size_t kEffects = 4;
  constexpr int kVariants = 3;
  constexpr double kShare = 0.5;
  std::vector<Candidate> candidates = shortlist(screen, fit, kEffects);
  double best = 0.0;
  for (const Candidate& c : candidates) best = std::max(best, c.within);
  std::map<const Effect*, int> taken;
  std::erase_if(candidates, [&](const Candidate& c) {
    return c.within < kShare * best || ++taken[c.effect] > kVariants;
  });
  return candidates;
}

/// Adds other effects whose columns span nearly the same as the chosen candidate's. Those that the
/// columns cannot tell apart are refitted too, and so among the rivals.
void add_look_alikes(const Screen& screen, const Chain& chain, FieldFinding& finding) {
  constexpr double kAlike = 0.95;
  const Trial& chosen = finding.trial;
  const Candidate* own = nullptr;
  for (const Candidate& c : screen.candidates)
    if (c.effect == chosen.effect && c.variant.words == chosen.variant.words && !own) own = &c;
  if (own == nullptr) return;
  std::map<std::string, std::pair<double, const Candidate*>> best;
  for (const Candidate& c : screen.candidates) {
    // what spans more contains the smaller one: that says nothing against it
    if (c.effect == chosen.effect || c.df > own->df || c.space.rows() != own->space.rows())
      continue;
    auto& [largest, candidate] = best[c.effect->id];
    const double correlation = canonical_correlation(own->space, c.space);
    if (correlation > largest) largest = correlation, candidate = &c;
  }
  for (const auto& [id, found] : best) {
    const auto& [correlation, candidate] = found;
    if (correlation <= kAlike) continue;
    LookAlike alike = {id, correlation, own->gain * (1.0 - correlation * correlation)};
    if (alike.told_apart < kDecisive) {
      FieldTrial trial =
          refit_field(*candidate, chain.current, chain.d.data, field_options(chain.control));
      alike.is_refitted = trial.trial.fit.usable;
      if (alike.is_refitted) finding.rivals.push_back(std::move(trial.trial));
    }
    finding.look_alikes.push_back(std::move(alike));
  }
}

std::string objection_of_kinds(const Trial& trial, const Chain& chain) {
  const auto misfit = [&](const estimation::FitResult& fit) {
    return misfit_of(chain.d.data.sequences, chain.current.rows, fit.residuals);
  };
  const bool is_more_of_one =
      std::any_of(chain.accepted.begin(), chain.accepted.end(),
                  [&](const FieldFinding& f) { return f.trial.effect == trial.effect; });
  const Misfit now = misfit(chain.current.at.fit);
  if (std::string why =
          objection_of_grid(chain.d.taken_by_grid, now, misfit(trial.fit), trial.variant);
      !why.empty())
    return why;
  std::array<double, 2> taken = {0.0, 0.0};
  for (const FieldFinding& found : chain.accepted) {
    if (found.trial.effect->is_exact) continue;
    const Misfit after = misfit(found.trial.fit);
    for (std::size_t kind : {0UL, 1UL}) taken[kind] += found.before.chi2[kind] - after.chi2[kind];
  }
  return objection_by_kind(taken, now, misfit(trial.fit), is_more_of_one);
}

/// Forward: one effect at a time, the best that passes, until none does.
Expected<void> go_forward(Chain& chain) {
  SheetDiagnosis& d = chain.d;
  const Options& asked = chain.request.options;
  for (int round = 0; round < asked.max_effects; ++round) {
    const double fraction = 0.1 + 0.7 * round / std::max(1, asked.max_effects);
    chain.control.report({"screen", "round " + std::to_string(round + 1), round,
                          chain.current.at.fit.chi2, fraction});
    const auto found = screen_field(
        chain.current, d.data, d.excitation,
        {asked.null_twins, asked.seed + 1000ULL * static_cast<unsigned long long>(round), true,
         asked.effects},
        chain.control.threads);
    if (!found) return tl::unexpected(found.error());
    if (round == 0) d.first_screen = *found;
    const std::vector<Candidate> candidates = worth_a_refit(*found, chain.current.at.fit);
    if (candidates.empty() || chain.stopped()) return {};
    chain.control.report(
        {"refit", standing_of(*found, chain), round, chain.current.at.fit.chi2, fraction + 0.03});
    std::vector<FieldTrial> trials = refit_all(candidates, chain);
    std::size_t chosen = trials.size();
    for (std::size_t i = 0; i < trials.size() && chosen == trials.size(); ++i) {
      if (chain.stopped()) return {};
      Trial& trial = trials[i].trial;
      chain.control.report({"gates", trial.effect->id + ", " + trial.variant.words, round,
                            trial.fit.chi2, fraction + 0.06});
      judge_field(trials[i], chain.current, d.data, chain.held_out_sheets(), found->expected_chi2,
                  field_options(chain.control));
      if (std::string why = objection_of_kinds(trial, chain); !why.empty())
        trial.objections.push_back(std::move(why));
      if (trial.objections.empty()) {
        chosen = i;
        continue;
      }
      const FieldFit at{reference_of(trial), {}, chain.current.rows};
      PathStep step = step_of("reject", trial.effect->id,
                              trial.variant.words + ": " + trial.objections.front(), at, d);
      step.p_value = trial.p_value;
      d.path.push_back(std::move(step));
    }
    if (chosen == trials.size()) return {};
    FieldFinding finding;
    finding.trial = trials[chosen].trial;
    finding.before =
        misfit_of(d.data.sequences, chain.current.rows, chain.current.at.fit.residuals);
    for (std::size_t i = 0; i < trials.size(); ++i)
      if (i != chosen && trials[i].trial.effect != finding.trial.effect)
        finding.rivals.push_back(trials[i].trial);
    add_look_alikes(*found, chain, finding);
    take(chain, trials[chosen]);
    PathStep step =
        step_of("add", finding.trial.effect->id, finding.trial.variant.words, chain.current, d);
    step.p_value = finding.trial.p_value;
    d.path.push_back(std::move(step));
    chain.accepted.push_back(std::move(finding));
  }
  return {};
}

/// Takes an effect out, refits, and keeps it out where `why_needless` says so of the refit.
template <class WhyNeedless>
void drop_where(Chain& chain, WhyNeedless&& why_needless) {
  for (const std::string& id : effects_of(chain)) {
    if (chain.stopped()) return;
    auto reduced = fit_field(without(chain.current.at.model, id, chain.d.baseline.at.model),
                             chain.d.data, chain.current.states, field_options(chain.control));
    if (!reduced) continue;
    const std::string why = why_needless(id, *reduced);
    if (why.empty()) continue;
    chain.current = std::move(*reduced);
    std::erase_if(chain.accepted, [&](const FieldFinding& f) { return f.trial.effect->id == id; });
    chain.d.path.push_back(step_of("drop", id, why, chain.current, chain.d));
  }
}

/// Effects of which nothing is left that is their own, now that others are there too, are what they
/// are without that.
void put_in_plain_form(Chain& chain) {
  for (const std::string& id : effects_of(chain)) {
    const Effect* effect = find_effect(id);
    const auto model = in_plain_form(chain.current.at, *effect);
    if (!model || chain.stopped()) continue;
    auto plain =
        fit_field(*model, chain.d.data, chain.current.states, field_options(chain.control));
    if (!plain || made_needless(plain->at, chain.current.at).empty()) continue;
    chain.current = std::move(*plain);
    for (FieldFinding& f : chain.accepted)
      if (f.trial.effect->id == id) f.trial.effect = find_effect(effect->plain_form);
    chain.d.path.push_back(step_of("drop", effect->id, kPlainIsEnough, chain.current, chain.d));
    chain.d.path.push_back(
        step_of("add", effect->plain_form, "in its place", chain.current, chain.d));
  }
}

/// Backward: what later additions made needless goes.
void go_backward(Chain& chain) {
  put_in_plain_form(chain);
  if (chain.accepted.size() < 2) return;
  drop_where(chain, [&](const std::string&, const FieldFit& reduced) {
    return made_needless(reduced.at, chain.current.at);
  });
}

/// Of what an effect was found by, positions or all else: what it explained of what was missed when
/// it came in, and what is missed there still, of what the baseline missed.
struct Part {
  double share = 0.0;
  double left = 0.0;
  bool is_met = false;  ///< nothing beyond the noise
};

Part part_of(const Chain& chain, const FieldFinding& finding, double noise) {
  const auto misfit = [&](const Eigen::VectorXd& residuals) {
    return misfit_of(chain.d.data.sequences, chain.current.rows, residuals);
  };
  const Misfit after = misfit(finding.trial.fit.residuals);
  const Misfit first = misfit(chain.d.baseline.at.fit.residuals);
  const Misfit now = misfit(chain.current.at.fit.residuals);
  constexpr double kBeside = 0.1;  // of the gain: what shows in passing is no proof
  const auto gained = [&](std::size_t k) { return finding.before.chi2[k] - after.chi2[k]; };
  Part best;
  for (const std::size_t k : {0UL, 1UL}) {
    if (gained(k) < kBeside * gained(1 - k)) continue;
    const double expected = noise * now.rows[k];
    const double missed = finding.before.chi2[k] - expected;
    const double share = missed > 0.0 ? gained(k) / missed : 0.0;
    if (share <= best.share) continue;
    // where nothing is missed any more nothing is stood in for
    const bool is_met = now.chi2[k] <= 1.1 * expected;
    best.share = share;
    best.left =
        is_met ? 0.0 : (now.chi2[k] - expected) / std::max(missed, first.chi2[k] - expected);
    best.is_met = is_met;
  }
  return best;
}

/// Positions or all else are missed by more than a tenth of the noise's power: thousands of points
/// would outvote the forces. What only scatters is not missed.
bool misses_a_kind(const Chain& chain, double expected) {
  std::array<double, 2> chi2 = {0.0, 0.0}, allowed = {0.0, 0.0};
  const double noise = expected / static_cast<double>(chain.current.rows.size());
  for (const Structure& s :
       structure_of(chain.d.data.sequences, chain.current.rows, chain.current.at.fit.residuals)) {
    const std::size_t kind = s.kind == estimation::ObservationKind::position ? 0 : 1;
    chi2[kind] += s.chi2;
    allowed[kind] +=
        is_scatter(s, chain.d.noise) ? std::max(s.chi2, noise * s.rows) : noise * s.rows;
  }
  return chi2[0] > 1.1 * allowed[0] || chi2[1] > 1.1 * allowed[1];
}

/// Where the model still misses more than the noise, an effect that explained little of what was
/// missed when it came in is a stand-in for something that the catalogue lacks: it gets no name.
void drop_stand_ins(Chain& chain) {
  SheetDiagnosis& d = chain.d;
  const double expected = expected_chi2(d.baseline);
  if (!(d.last_screen.lack_of_fit > 1.0) || !misses_a_kind(chain, expected)) return;
  std::map<std::string, Part> best;
  for (const FieldFinding& f : chain.accepted) {
    const Part part = part_of(chain, f, expected / static_cast<double>(d.baseline.rows.size()));
    Part& known = best[f.trial.effect->id];
    if (part.share > known.share) known = part;
  }
  drop_where(chain, [&](const std::string& id, const FieldFit&) {
    const bool is_exact = find_effect(id)->is_exact && best.size() == 1;
    return best[id].is_met ? std::string() : stands_in(best[id].share, best[id].left, is_exact);
  });
}

Expected<void> look_again(Chain& chain) {
  const Options& asked = chain.request.options;
  auto found = screen_field(chain.current, chain.d.data, chain.d.excitation,
                            {asked.null_twins, asked.seed + 99, false, asked.effects},
                            chain.control.threads);
  if (!found) return tl::unexpected(found.error());
  chain.d.last_screen = std::move(*found);
  return {};
}

void name_extended(Chain& chain) {
  model::Model& model = chain.d.extended.at.model;
  model.name = chain.request.model.name + (chain.accepted.empty() ? "" : ", extended");
  model::Lineage lineage;
  lineage.parent = chain.request.model.name;
  for (const FieldFinding& f : chain.accepted) lineage.added.push_back(f.trial.effect->id);
  lineage.captures = chain.d.data.ids;
  model.lineage = lineage;
}

}  // namespace

Expected<SheetDiagnosis> diagnose_sheets(const SheetRequest& request, const Control& control) {
  auto prepared = prepare_sheets(request, control);
  if (!prepared) return prepared;
  SheetDiagnosis& d = *prepared;
  if (auto ok = check_grid(request, control, d); !ok) return tl::unexpected(ok.error());
  Chain chain{request, control, d, d.baseline, d.held_out_baseline, {}};
  d.path.push_back(step_of("start", "", request.model.name, d.baseline, d));
  const auto cancelled = [] {
    return fail(ErrorKind::cancelled, "stopped while effects were being tried");
  };
  if (auto ok = go_forward(chain); !ok) return tl::unexpected(ok.error());
  if (chain.stopped()) return cancelled();
  go_backward(chain);
  if (auto ok = look_again(chain); !ok) return tl::unexpected(ok.error());
  // without stand-ins more is unexplained, and more is asked of the names that are left
  for (std::size_t found = chain.accepted.size() + 1; chain.accepted.size() < found;) {
    found = chain.accepted.size();
    drop_stand_ins(chain);
    if (chain.stopped()) return cancelled();
    if (chain.accepted.size() < found)
      if (auto ok = look_again(chain); !ok) return tl::unexpected(ok.error());
  }
  d.extended = chain.current;
  name_extended(chain);
  d.findings = std::move(chain.accepted);
  control.report({"held out", "", 0, d.extended.at.fit.chi2, 0.9});
  measure_sheet_gain(d, request, control);
  control.report({"verdicts", "", 0, d.extended.at.fit.chi2, 0.95});
  pass_sheet_verdicts(d, request, control);
  return prepared;
}

}  // namespace tenter::diagnosis
