// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/field_verdicts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "server/diagnosis/field/field_gain.h"
#include "server/diagnosis/field/next/clip_bench.h"
#include "server/diagnosis/field/prepare_sheet.h"
#include "server/diagnosis/field/screen/field_screen.h"
#include "server/diagnosis/trials/model_edit.h"
#include "server/diagnosis/verdicts/verdict_words.h"

namespace tenter::diagnosis {
namespace {

void add_once(std::vector<std::string>& list, const std::string& id) {
  if (std::find(list.begin(), list.end(), id) == list.end()) list.push_back(id);
}

/// How many rows tell of what was found: the mean of their logarithm over positions and all else,
/// by what is explained of each. Ten thousand positions say nothing of an effect that forces show.
double telling_rows(const SheetDiagnosis& d, const std::vector<const FieldFinding*>& findings) {
  double gain = 0.0, sum = 0.0;
  for (const FieldFinding* f : findings) {
    const Misfit after = misfit_of(d.data.sequences, d.extended.rows, f->trial.fit.residuals);
    for (const std::size_t k : {0UL, 1UL}) {
      const double own = std::max(0.0, f->before.chi2[k] - after.chi2[k]);
      gain += own;
      sum += own * std::log(std::max(1.0, after.rows[k]));
    }
  }
  return gain > 0.0 ? std::min(std::exp(sum / gain), d.extended.at.fit.effective_rows) : 0.0;
}

/// The extended model with an effect's rival in its place.
struct Swapped {
  std::string id;
  FieldFit fitted;
  bool is_equal = false;  ///< it does as well as the effect does
};

std::vector<Swapped> swapped_rivals(const SheetDiagnosis& d, const std::string& effect,
                                    const std::vector<Trial>& rivals, double telling,
                                    const Control& control) {
  std::vector<Swapped> all;
  std::set<std::string> tried;
  for (const Trial& rival : rivals) {
    const std::string& id = rival.effect->id;
    if (tried.contains(id) || id == effect) continue;
    if (says_nothing_against(id, effect)) continue;
    if (holds(d.extended.at.model, id)) continue;
    auto fitted =
        fit_field(with_rival(without(d.extended.at.model, effect, d.baseline.at.model), rival),
                  d.data, d.extended.states, field_options(control));
    if (!fitted) continue;
    tried.insert(id);
    const double rows = is_case_of(effect, id) ? 0.0 : telling;
    const bool is_equal = evidence_against(fitted->at, d.extended.at, rows) < kDecisive;
    all.push_back({id, std::move(*fitted), is_equal});
  }
  return all;
}

/// What to capture next: where clips may lead a sheet so that it splits the effect from those of
/// its alternatives that were fitted; else the protocol of the effect's row.
void propose_next(const SheetDiagnosis& d, const Effect& effect,
                  const std::vector<Swapped>& swapped, const RigLimits& rig, const Control& control,
                  Verdict& verdict) {
  verdict.next_protocol = effect.split_by;
  const std::vector<std::string> split = to_be_split(effect.id, verdict.alternatives);
  std::vector<const FieldFit*> rivals = {&d.extended};
  std::vector<const Reference*> causes = {&d.extended.at};
  for (const Swapped& other : swapped) {
    if (std::ranges::find(split, other.id) == split.end()) continue;
    rivals.push_back(&other.fitted);
    causes.push_back(&other.fitted.at);
  }
  if (causes.size() < 2 || control.stop.stop_requested()) return;
  verdict.design = design_next(causes, clip_bench(rivals, d.data, rig, control.threads), rig,
                               question_of(effect.id, verdict.alternatives));
  if (verdict.design) describe(*verdict.design, *verdict.next_protocol);
}

/// Correlation in space and time of what an effect explains, in numbers.
void add_structure(const SheetDiagnosis& d, Verdict& verdict) {
  for (const Structure& s : d.structure) {
    if (s.rows == 0) continue;
    const std::string& name = d.data.sequences[static_cast<std::size_t>(s.sequence)].name;
    const std::string kind = s.kind == estimation::ObservationKind::position ? "points"
                             : s.kind == estimation::ObservationKind::force  ? "forces"
                                                                             : "others";
    verdict.evidence.emplace_back(name + " " + kind + " chi2 over noise", s.chi2 / s.rows);
  }
}

Verdict verdict_for(const SheetDiagnosis& d, const std::string& id,
                    const std::vector<const FieldFinding*>& findings, const Options& options,
                    const Control& control) {
  const Effect& effect = *find_effect(id);
  Verdict verdict;
  std::vector<const Trial*> trials;
  std::vector<Trial> rivals;
  for (const FieldFinding* f : findings) {
    trials.push_back(&f->trial);
    rivals.insert(rivals.end(), f->rivals.begin(), f->rivals.end());
  }
  const std::vector<Swapped> swapped =
      swapped_rivals(d, id, rivals, telling_rows(d, findings), control);
  for (const Swapped& other : swapped)
    if (other.is_equal) verdict.alternatives.push_back(other.id);
  std::vector<std::pair<std::string, double>> alike;
  for (const FieldFinding* f : findings)
    for (const LookAlike& other : f->look_alikes) {
      alike.emplace_back("canonical correlation with " + other.effect, other.correlation);
      if (other.told_apart < kDecisive && !other.is_refitted &&
          !holds(d.extended.at.model, other.effect) && !says_nothing_against(other.effect, id))
        add_once(verdict.alternatives, other.effect);
    }
  add_untold(effect, d.excitation, verdict.alternatives);
  auto reduced = fit_field(without(d.extended.at.model, id, d.baseline.at.model), d.data,
                           d.extended.states, field_options(control));
  const SizeInterval size =
      sheet_effect_size(d.data, reduced ? *reduced : d.baseline, d.extended, options.seed);
  put_in_words(effect, trials, size, size.of_force ? "force" : "motion of the points",
               "these captures", d.data.block_count(), verdict);
  if (!verdict.alternatives.empty())
    propose_next(d, effect, swapped, options.rig, control, verdict);
  verdict.evidence.emplace_back("independent_rows", d.extended.at.fit.effective_rows);
  verdict.evidence.insert(verdict.evidence.end(), alike.begin(), alike.end());
  add_structure(d, verdict);
  return verdict;
}

/// Points that were misread: nothing of a model, and left out of the fits.
void add_misread(SheetDiagnosis& d) {
  if (d.misread.empty()) return;
  Verdict verdict;
  verdict.kind = VerdictKind::sensor;
  verdict.effect = "outliers";
  double largest = 0.0, farthest_m = 0.0;
  std::map<std::string, int> by_capture;
  for (const Misread& m : d.misread) {
    largest = std::max(largest, m.score);
    farthest_m = std::max(farthest_m, std::abs(m.off_m));
    ++by_capture[d.data.sequences[static_cast<std::size_t>(m.sequence)].name];
  }
  Eigen::Index places = 0;
  for (const estimation::Sequence& sequence : d.data.sequences)
    places += static_cast<Eigen::Index>(sequence.points.size() * sequence.frames.size());
  verdict.size = verdict.size_lo = verdict.size_hi =
      static_cast<double>(d.misread.size()) / static_cast<double>(places);
  // chance that the largest of so many normal readings lies so far out
  verdict.p_value =
      std::min(1.0, 3.0 * static_cast<double>(places) * std::erfc(largest / std::sqrt(2.0)));
  char figures[48];
  std::snprintf(figures, sizeof figures, "%.2g mm", 1e3 * farthest_m);
  verdict.words = std::to_string(d.misread.size()) + " of " + std::to_string(places) +
                  " readings of points stand alone, up to " + figures +
                  " from what is near them in the material and in time, and were left out of the "
                  "fits:";
  for (const auto& [name, count] : by_capture)
    verdict.words += " " + std::to_string(count) + " in " + name + ",";
  verdict.words.back() = '.';
  verdict.evidence = {{"count", static_cast<double>(d.misread.size())},
                      {"largest_robust_score", largest}};
  d.verdicts.push_back(std::move(verdict));
}

/// Of positions and of all else: what is left is no more than the estimate of the grid's error may
/// miss.
std::array<bool, 2> within_grid(const SheetDiagnosis& d) {
  const Misfit left = misfit_of(d.data.sequences, d.extended.rows, d.extended.at.fit.residuals);
  std::array<bool, 2> is_within = {false, false};
  for (const std::size_t kind : {0UL, 1UL})
    is_within[kind] =
        is_within_form(left.chi2[kind] - left.rows[kind], d.taken_by_grid[kind], kFormOfGrid);
  return is_within;
}

/// Nothing would be missed if the noise were as the captures state it.
bool is_within_stated(const SheetDiagnosis& d) {
  return std::ranges::all_of(d.structure_left, [&](const Structure& s) {
    double factor = 1.0;
    for (const FieldNoise::Kind& kind : d.noise.kinds)
      if (kind.sequence == s.sequence && kind.kind == s.kind)
        factor = kind.is_guessed ? 1.0 : kind.factor;
    return s.chi2 * factor * factor <= 1.1 * s.rows;
  });
}

void add_unexplained(SheetDiagnosis& d, bool anything_found) {
  const double expected = expected_chi2(d.baseline);
  const double missed = std::max(0.0, d.baseline.at.fit.chi2 - expected);
  const double left = std::max(0.0, d.extended.at.fit.chi2 - expected_chi2(d.extended));
  d.unexplained_share = missed > 0.0 ? std::min(1.0, left / missed) : 0.0;
  // a tenth of the noise's power in some kind of channel is worth a word
  const std::array<bool, 2> is_of_grid = within_grid(d);
  bool lacks_fit = false;
  for (const Structure& s : d.structure_left) {
    const std::size_t kind = s.kind == estimation::ObservationKind::position ? 0 : 1;
    lacks_fit =
        lacks_fit || (s.rows > 0 && s.chi2 > 1.1 * s.rows && d.last_screen.lack_of_fit > 1.0 &&
                      !is_of_grid[kind] && !is_scatter(s, d.noise));
  }
  if (!lacks_fit) {
    d.unexplained_share = 0.0;
    if (!anything_found) d.verdicts.push_back(nothing_found(d.noise_floor));
    return;
  }
  Verdict verdict = unexplained(d, d.after.error);
  if (is_within_stated(d))
    verdict.words +=
        " It is within the noise that the captures state, of which neighbouring frames show less: "
        "noise that they share would look like this too, and a repeat would tell.";
  for (const Structure& s : d.structure_left) {
    if (s.kind != estimation::ObservationKind::position || s.rows == 0) continue;
    const std::string& name = d.data.sequences[static_cast<std::size_t>(s.sequence)].name;
    verdict.evidence.emplace_back(name + " correlation of neighbouring points", s.neighbours);
    verdict.evidence.emplace_back(name + " fixed to the material", s.fixed);
    verdict.evidence.emplace_back(name + " excess at free edges", s.at_edges);
    verdict.evidence.emplace_back(name + " linear in the place in space", s.with_place);
  }
  d.verdicts.push_back(std::move(verdict));
}

/// Faults of sensors that only curves know are not missed here.
bool is_asked_of_sheets(const Effect& effect) {
  return effect.kind != effects::Kind::sensor || effect.sheet_variants;
}

std::string names_in_state(const FieldFit& fit,
                           std::initializer_list<estimation::ParameterState> in) {
  const auto names = estimation::parameter_names(fit.at.model);
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::find(in.begin(), in.end(), fit.at.fit.states[i]) != in.end())
      list += (list.empty() ? "" : ", ") + names[i];
  return list;
}

void check_all(SheetDiagnosis& d) {
  using estimation::ParameterState;
  const auto add = [&](const char* level, std::string what, std::string why) {
    d.checklist.push_back({level, std::move(what), std::move(why)});
  };
  const auto& fit = d.extended.at.fit;
  add(fit.converged ? "OK" : "WARNING",
      fit.converged ? "The fit converged" : "The fit did not converge",
      fit.message + " after " + std::to_string(fit.iterations) + " iterations");
  const std::string at_bound = names_in_state(d.extended, {ParameterState::at_bound});
  const std::string unseen =
      names_in_state(d.extended, {ParameterState::zero_gradient, ParameterState::flat});
  if (!at_bound.empty()) add("WARNING", "Parameters stand at a bound", at_bound);
  if (!unseen.empty()) add("WARNING", "Parameters that these captures do not determine", unseen);
  if (at_bound.empty() && unseen.empty())
    add("OK", "Every parameter is determined", "none at a bound, none flat");
  for (const std::string& frame : d.dropped) add("WARNING", "A frame has no rest", frame);
  for (const FieldNoise::Kind& kind : d.noise.kinds) {
    if (kind.rows == 0) continue;
    char figures[96];
    const bool is_length = kind.kind == estimation::ObservationKind::position;
    const double unit = is_length ? 1e3 : 1.0;
    // few frames of a curved misfit scatter too: then the stated value stands unproved
    const bool is_unproved = kind.is_bound && kind.factor == 1.0 && kind.shown > kind.stated;
    std::snprintf(figures, sizeof figures, "%s %.3g, shown %s%.3g, taken %.3g %s",
                  kind.is_guessed ? "guessed" : "stated", unit * kind.stated,
                  kind.is_bound ? "at most " : "", unit * kind.shown,
                  unit * kind.stated * kind.factor, is_length ? "mm" : "N");
    const bool is_taken =
        (kind.factor == 1.0 && !kind.is_guessed) || kind.source == estimation::NoiseSource::repeats;
    add(is_taken && !is_unproved ? "OK" : "WARNING",
        "Noise of " + d.data.sequences[static_cast<std::size_t>(kind.sequence)].name + ", " +
            (is_length ? "points" : "forces") + ": " + estimation::noise_source_words(kind.source),
        figures);
  }
  const int blocks = d.data.block_count();
  if (blocks < 8)
    add("WARNING", "Only " + std::to_string(blocks) + " blocks (branches of loops)",
        "under eight, verdicts carry a weaker word");
  if (d.held_out_kind.empty())
    add("WARNING", "No error on left-out data", "there is too little to leave any out");
  else
    add("OK", "Errors on left-out " + d.held_out_kind,
        "each predicted by a fit that did not see it");
}

}  // namespace

void pass_sheet_verdicts(SheetDiagnosis& d, const SheetRequest& request, const Control& control) {
  d.structure = structure_of(d.data.sequences, d.baseline.rows, d.baseline.at.fit.residuals);
  d.structure_left = structure_of(d.data.sequences, d.extended.rows, d.extended.at.fit.residuals);
  std::vector<std::string> order;
  std::map<std::string, std::vector<const FieldFinding*>> by_effect;
  for (const FieldFinding& f : d.findings) {
    auto& list = by_effect[f.trial.effect->id];
    if (list.empty()) order.push_back(f.trial.effect->id);
    list.push_back(&f);
  }
  for (const std::string& id : order)
    d.verdicts.push_back(verdict_for(d, id, by_effect[id], request.options, control));
  std::stable_sort(d.verdicts.begin(), d.verdicts.end(),
                   [](const Verdict& a, const Verdict& b) { return a.size > b.size; });
  add_misread(d);
  add_unexplained(d, !d.verdicts.empty());
  add_not_excited(d, {order.begin(), order.end()}, is_asked_of_sheets);
  check_all(d);
}

}  // namespace tenter::diagnosis
