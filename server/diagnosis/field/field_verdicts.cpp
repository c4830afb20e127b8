// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/field/field_verdicts.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "server/diagnosis/field/field_gain.h"
#include "server/diagnosis/field/prepare_sheet.h"
#include "server/diagnosis/field/screen/field_screen.h"
#include "server/diagnosis/model_edit.h"

namespace tenter::diagnosis {
namespace {

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, share < 0.0995 ? "%.1f %%" : "%.0f %%", 100.0 * share);
  return text;
}

std::string list_words(const std::vector<std::string>& ids) {
  std::string words;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (i > 0) words += i + 1 == ids.size() ? " or " : ", ";
    words += find_effect(ids[i]) ? find_effect(ids[i])->words : ids[i];
  }
  return words;
}

bool is_rate_question(const std::string& effect) {
  return effect == "internal_friction" || effect == "strain_dependent_friction" ||
         effect == "viscosity";
}

constexpr double kDecisive = 10.0;  // twice the log evidence

/// What holds another effect as a special case does as well, which says nothing against the
/// simpler.
bool contains(const std::string& wider, const std::string& narrower) {
  return wider == "strain_dependent_friction" && narrower == "internal_friction";
}

void add_once(std::vector<std::string>& list, const std::string& id) {
  if (std::find(list.begin(), list.end(), id) == list.end()) list.push_back(id);
}

/// Rivals that do as well in the extended model as the effect does.
std::vector<std::string> equals_of(const SheetDiagnosis& d, const std::string& effect,
                                   const std::vector<Trial>& rivals, const Control& control) {
  std::vector<std::string> equals;
  std::set<std::string> tried;
  for (const Trial& rival : rivals) {
    if (tried.contains(rival.effect->id) || rival.effect->id == effect) continue;
    if (contains(rival.effect->id, effect)) continue;
    if (holds(d.extended.at.model, rival.effect->id)) continue;
    auto swapped =
        fit_field(with_rival(without(d.extended.at.model, effect, d.baseline.at.model), rival),
                  d.data, d.extended.states, field_options(control));
    if (!swapped) continue;
    const double rows = std::max(swapped->at.fit.effective_rows, d.extended.at.fit.effective_rows);
    const double evidence =
        information(swapped->at.fit.chi2, free_count(swapped->at.model), 0, rows) -
        information(d.extended.at.fit.chi2, free_count(d.extended.at.model), 0, rows);
    tried.insert(rival.effect->id);
    if (evidence < kDecisive) equals.push_back(rival.effect->id);
  }
  return equals;
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
                    const std::vector<const FieldFinding*>& findings, unsigned long long seed,
                    const Control& control) {
  const Effect& effect = *find_effect(id);
  Verdict verdict;
  verdict.effect = id;
  verdict.p_value = findings.front()->trial.p_value;
  auto reduced = fit_field(without(d.extended.at.model, id, d.baseline.at.model), d.data,
                           d.extended.states, field_options(control));
  const Eigen::VectorXd& rest = reduced ? reduced->at.fit.residuals : d.baseline.at.fit.residuals;
  const int blocks = d.data.block_count();
  const FieldSize size =
      size_between(d.data, d.extended.rows, rest, d.extended.at.fit.residuals, blocks, seed);
  verdict.size = size.size;
  verdict.size_lo = size.lo;
  verdict.size_hi = size.hi;

  std::vector<Trial> rivals;
  for (const FieldFinding* f : findings)
    rivals.insert(rivals.end(), f->rivals.begin(), f->rivals.end());
  verdict.alternatives = equals_of(d, id, rivals, control);
  for (const FieldFinding* f : findings)
    for (const LookAlike& other : f->look_alikes) {
      verdict.evidence.emplace_back("canonical correlation with " + other.effect,
                                    other.correlation);
      if (other.told_apart < kDecisive && !holds(d.extended.at.model, other.effect) &&
          !contains(other.effect, id))
        add_once(verdict.alternatives, other.effect);
    }
  // physics, not statistics: at one rate without a hold Maxwell equals Dahl
  if (is_rate_question(id) && !d.excitation.splits_rate())
    add_once(verdict.alternatives, id == "viscosity" ? "internal_friction" : "viscosity");
  if (effect.needs_rate && !d.excitation.has_rate && verdict.alternatives.empty())
    verdict.alternatives.push_back(effect.mistaken_for.front());

  std::string words = effect.words;
  words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  if (!verdict.alternatives.empty()) {
    verdict.kind = VerdictKind::ambiguous;
    words += "; these captures cannot tell it from " + list_words(verdict.alternatives);
    verdict.next_protocol = effect.split_by;
  } else {
    verdict.kind = effect.kind == effects::Kind::sensor ? VerdictKind::sensor : VerdictKind::named;
  }
  words += ". It accounts for " + percent(verdict.size) +
           (size.of_force ? " of the force" : " of the motion of the points");
  std::string variants;
  for (const FieldFinding* f : findings)
    variants += (variants.empty() ? " (" : "; ") + f->trial.variant.words;
  words += variants + ")";
  const Trial& first = findings.front()->trial;
  if (first.held_out_before > 0.0)
    words += " and takes " + percent(1.0 - first.held_out_after / first.held_out_before) +
             " off the squared error on left-out " + first.folds;
  words += ".";
  const bool few_blocks = blocks < 8;
  if (few_blocks) words += " Too few repeats for more than a weak word.";
  verdict.words = words;
  verdict.evidence.insert(verdict.evidence.begin(),
                          {{"screen_ratio", first.ratio},
                           {"f_test_p", first.p_value},
                           {"independent_rows", d.extended.at.fit.effective_rows},
                           {"blocks", static_cast<double>(blocks)},
                           {"few_repeats", few_blocks ? 1.0 : 0.0}});
  add_structure(d, verdict);
  return verdict;
}

void add_unexplained(SheetDiagnosis& d, bool anything_found) {
  const double expected = expected_chi2(d.baseline);
  const double missed = std::max(0.0, d.baseline.at.fit.chi2 - expected);
  const double left = std::max(0.0, d.extended.at.fit.chi2 - expected_chi2(d.extended));
  d.unexplained_share = missed > 0.0 ? std::min(1.0, left / missed) : 0.0;
  // a tenth of the noise's power in some kind of channel is worth a word
  bool lacks_fit = false;
  for (const Structure& s : d.structure_left)
    lacks_fit =
        lacks_fit || (s.rows > 0 && s.chi2 > 1.1 * s.rows && d.last_screen.lack_of_fit > 1.0);
  Verdict verdict;
  if (!lacks_fit) {
    d.unexplained_share = 0.0;
    if (anything_found) return;
    verdict.words = "Nothing found: what the model misses is no larger than the noise, " +
                    percent(d.noise_floor) + " of the force.";
    d.verdicts.push_back(std::move(verdict));
    return;
  }
  verdict.kind = VerdictKind::unexplained;
  verdict.size =
      std::sqrt(std::max(0.0, d.after.error * d.after.error - d.noise_floor * d.noise_floor));
  verdict.size_lo = verdict.size_hi = verdict.size;
  verdict.words =
      percent(d.unexplained_share) +
      " of what the baseline missed beyond the noise is explained by no effect of the catalogue; " +
      percent(verdict.size) + " of the force.";
  verdict.evidence = {{"lack_of_fit", d.last_screen.lack_of_fit},
                      {"unexplained_share", d.unexplained_share}};
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

void add_not_excited(SheetDiagnosis& d, const std::set<std::string>& found) {
  for (const ScreenRow& row : d.first_screen.table) {
    if (found.contains(row.effect->id) || !row.status.starts_with("not excited")) continue;
    if (row.effect->kind == effects::Kind::sensor && !row.effect->sheet_variants) continue;
    Verdict verdict;
    verdict.kind = VerdictKind::not_excited;
    verdict.effect = row.effect->id;
    verdict.words =
        "These captures cannot show " + row.effect->words + " (" + row.status.substr(13) + ").";
    verdict.next_protocol = row.effect->split_by;
    d.verdicts.push_back(std::move(verdict));
  }
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
    std::snprintf(figures, sizeof figures, "stated %.3g, shown %s%.3g, taken %.3g %s",
                  unit * kind.stated, kind.is_bound ? "at most " : "", unit * kind.shown,
                  unit * kind.stated * kind.factor, is_length ? "mm" : "N");
    const bool is_taken = kind.factor == 1.0 || kind.source == estimation::NoiseSource::repeats;
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
    d.verdicts.push_back(verdict_for(d, id, by_effect[id], request.options.seed, control));
  std::stable_sort(d.verdicts.begin(), d.verdicts.end(),
                   [](const Verdict& a, const Verdict& b) { return a.size > b.size; });
  add_unexplained(d, !d.verdicts.empty());
  add_not_excited(d, {order.begin(), order.end()});
  check_all(d);
}

}  // namespace tenter::diagnosis
