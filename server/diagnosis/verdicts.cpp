// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "server/diagnosis/checks/lattice.h"
#include "server/diagnosis/effect_size.h"
#include "server/diagnosis/model_edit.h"
#include "server/diagnosis/next/design.h"
#include "server/diagnosis/prepare.h"
#include "server/diagnosis/score.h"

namespace tenter::diagnosis {
namespace {

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, share < 0.0995 ? "%.1f %%" : "%.0f %%", 100.0 * share);
  return text;
}

/// The extended model with another effect in the place of one that was found.
struct Swapped {
  std::string id;
  Reference fitted;
  bool is_equal = false;  ///< twice the log evidence that speaks against it is small
};

std::vector<Swapped> swapped_rivals(const Diagnosis& d, const std::string& effect,
                                    const std::vector<Trial>& rivals) {
  constexpr double kDecisive = 10.0;
  std::vector<Swapped> all;
  std::set<std::string> tried;
  for (const Trial& rival : rivals) {
    if (tried.contains(rival.effect->id) || rival.effect->id == effect) continue;
    // friction that grows with strain contains constant friction: that it does as well says nothing
    // against the simpler
    if (effect == "internal_friction" && rival.effect->id == "strain_dependent_friction") continue;
    if (holds(d.extended.model, rival.effect->id)) continue;
    auto swapped = make_reference(
        with_rival(without(d.extended.model, effect, d.baseline.model), rival), d.data, {});
    if (!swapped) continue;
    const double rows = std::max(swapped->fit.effective_rows, d.extended.fit.effective_rows);
    const double evidence = information(swapped->fit.chi2, free_count(swapped->model), 0, rows) -
                            information(d.extended.fit.chi2, free_count(d.extended.model), 0, rows);
    tried.insert(rival.effect->id);
    all.push_back({rival.effect->id, std::move(*swapped), evidence < kDecisive});
  }
  return all;
}

bool is_rate_question(const std::string& effect) {
  return effect == "internal_friction" || effect == "strain_dependent_friction" ||
         effect == "viscosity";
}

/// What to capture next: the pull that splits the effect from its alternatives, where one does;
/// else the protocol of the effect's row.
void propose_next(const Diagnosis& d, const Effect& effect, const std::vector<Swapped>& swapped,
                  const RigLimits& rig, Verdict& verdict) {
  verdict.next_protocol = effect.split_by;
  std::vector<const Reference*> causes = {&d.extended};
  for (const std::string& id : verdict.alternatives)
    for (const Swapped& other : swapped)
      if (other.id == id) causes.push_back(&other.fitted);
  if (causes.size() <= verdict.alternatives.size()) return;
  const bool of_rate =
      is_rate_question(effect.id) &&
      std::any_of(verdict.alternatives.begin(), verdict.alternatives.end(), is_rate_question);
  verdict.design = design_next(causes, *d.data, rig, of_rate ? Question::of_rate : Question::any);
  if (!verdict.design) return;
  const Design& design = *verdict.design;
  char apart[32];
  std::snprintf(apart, sizeof apart, "%.2g", design.separation.of_noise());
  verdict.next_protocol->name = design.plan.name;
  verdict.next_protocol->words =
      "A new specimen, mounted as in \"" + design.mounted_as + "\", pulled as listed: of " +
      std::to_string(design.considered) +
      " pulls within the rig's limits the one that splits them best. What the causes foretell "
      "differs by " +
      apart + " times the noise there, after the wrong one has given way.";
  verdict.next_protocol->phases.clear();
  for (std::size_t i = 0; i < design.plan.steps.size(); ++i)
    verdict.next_protocol->phases.push_back(
        {design.plan.steps[i].is_hold ? "hold" : "ramp", words_of(design.plan)[i]});
}

std::string list_words(const std::vector<std::string>& ids) {
  std::string words;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (i > 0) words += i + 1 == ids.size() ? " or " : ", ";
    words += find_effect(ids[i]) ? find_effect(ids[i])->words : ids[i];
  }
  return words;
}

Verdict verdict_for(const Diagnosis& d, const std::string& id,
                    const std::vector<const Finding*>& findings, const Excitation& excitation,
                    const Options& options) {
  const Effect& effect = *find_effect(id);
  Verdict verdict;
  verdict.effect = id;
  verdict.p_value = findings.front()->trial.p_value;

  auto reduced = make_reference(without(d.extended.model, id, d.baseline.model), d.data, {});
  const SizeInterval size =
      effect_size(*d.data, reduced ? reduced->fit : d.baseline.fit, d.extended.fit, options.seed);
  verdict.size = size.size;
  verdict.size_lo = size.lo;
  verdict.size_hi = size.hi;

  std::vector<Trial> rivals;
  for (const Finding* f : findings) rivals.insert(rivals.end(), f->rivals.begin(), f->rivals.end());
  const std::vector<Swapped> swapped = swapped_rivals(d, id, rivals);
  for (const Swapped& other : swapped)
    if (other.is_equal) verdict.alternatives.push_back(other.id);
  // physics, not statistics: at one rate without a hold Maxwell equals Dahl
  if (is_rate_question(id) && !excitation.splits_rate()) {
    const std::string other = id == "viscosity" ? "internal_friction" : "viscosity";
    if (std::find(verdict.alternatives.begin(), verdict.alternatives.end(), other) ==
        verdict.alternatives.end())
      verdict.alternatives.push_back(other);
  }
  if (effect.needs_rate && !excitation.has_rate && verdict.alternatives.empty())
    verdict.alternatives.push_back(effect.mistaken_for.front());

  const bool few_blocks = d.data->block_count() < 8;
  std::string words = effect.words;
  words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  if (!verdict.alternatives.empty()) {
    verdict.kind = VerdictKind::ambiguous;
    words += "; this capture cannot tell it from " + list_words(verdict.alternatives);
    propose_next(d, effect, swapped, options.rig, verdict);
  } else {
    verdict.kind = effect.kind == effects::Kind::sensor ? VerdictKind::sensor : VerdictKind::named;
  }
  words += ". It accounts for " + percent(verdict.size) +
           (size.of_force ? " of the force" : " of the free stretch");
  std::string variants;
  for (const Finding* f : findings)
    variants += (variants.empty() ? " (" : "; ") + f->trial.variant.words;
  words += variants + ")";
  const Trial& first = findings.front()->trial;
  if (first.held_out_before > 0.0)
    words += " and takes " + percent(1.0 - first.held_out_after / first.held_out_before) +
             " off the squared error on left-out " + first.folds;
  words += ".";
  if (few_blocks) words += " Too few repeats for more than a weak word.";
  verdict.words = words;
  verdict.evidence = {{"screen_ratio", first.ratio},
                      {"f_test_p", first.p_value},
                      {"blocks", static_cast<double>(d.data->block_count())},
                      {"few_repeats", few_blocks ? 1.0 : 0.0}};
  return verdict;
}

void add_outliers(Diagnosis& d) {
  if (d.outliers.empty()) return;
  Verdict verdict;
  verdict.kind = VerdictKind::sensor;
  verdict.effect = "outliers";
  double worst = 0.0;
  double power = 0.0;
  double error = 0.0;
  std::size_t readings = 0;
  std::map<std::string, int> by_channel;
  for (const estimation::Outlier& o : d.outliers) {
    worst = std::max(worst, o.score);
    error += o.deviation * o.deviation;
    ++by_channel[d.curves[static_cast<std::size_t>(o.curve)]
                     .channels[static_cast<std::size_t>(o.channel)]
                     .name];
  }
  for (const estimation::Curves& c : d.curves) {
    for (const auto& channel : c.channels) {
      readings += channel.measured.size();
      for (const double v : channel.measured)
        if (std::isfinite(v)) power += v * v;
    }
  }
  verdict.size = power > 0.0 ? std::sqrt(error / power) : 0.0;
  verdict.size_lo = verdict.size_hi = verdict.size;
  // chance that the largest of so many normal readings lies so far out
  verdict.p_value =
      std::min(1.0, static_cast<double>(readings) * std::erfc(worst / std::sqrt(2.0)));
  verdict.words = std::to_string(d.outliers.size()) + " of " + std::to_string(readings) +
                  " readings stand alone far from their neighbours and were left out of the fits:";
  for (const auto& [name, count] : by_channel)
    verdict.words += " " + std::to_string(count) + " in " + name + ",";
  verdict.words.back() = '.';
  verdict.evidence = {{"count", static_cast<double>(d.outliers.size())},
                      {"largest_robust_score", worst}};
  d.verdicts.push_back(std::move(verdict));
}

void add_unexplained(Diagnosis& d, bool anything_found) {
  const Screen& last = d.last_screen;
  const double expected = noise_chi2(d);
  const double missed = std::max(0.0, d.baseline.fit.chi2 - expected);
  const double left = std::max(0.0, d.extended.fit.chi2 - expected);
  d.unexplained_share = missed > 0.0 ? std::min(1.0, left / missed) : 0.0;
  const bool lacks_fit = lacks_fit_still(d);
  if (!lacks_fit) {
    d.unexplained_share = 0.0;
    if (anything_found) return;
    Verdict verdict;
    verdict.words = "Nothing found: what the model misses is no larger than the noise, " +
                    percent(d.noise_floor) + " of the force.";
    d.verdicts.push_back(std::move(verdict));
    return;
  }
  Verdict verdict;
  verdict.kind = VerdictKind::unexplained;
  verdict.size =
      std::sqrt(std::max(0.0, d.after.error * d.after.error - d.noise_floor * d.noise_floor));
  verdict.size_lo = verdict.size_hi = verdict.size;
  verdict.words =
      percent(d.unexplained_share) +
      " of what the baseline missed beyond the noise is explained by no effect of the catalogue; " +
      percent(verdict.size) + " of the force.";
  if (irreproducible(d))
    verdict.words +=
        " Repeats of the same path differ smoothly by far more than neighbouring samples scatter.";
  verdict.evidence = {{"lack_of_fit", last.lack_of_fit},
                      {"unexplained_share", d.unexplained_share}};
  d.verdicts.push_back(std::move(verdict));
}

void add_not_excited(Diagnosis& d, const std::set<std::string>& found) {
  for (const ScreenRow& row : d.first_screen.table) {
    if (found.contains(row.effect->id) || !row.status.starts_with("not excited")) continue;
    Verdict verdict;
    verdict.kind = VerdictKind::not_excited;
    verdict.effect = row.effect->id;
    verdict.words =
        "These captures cannot show " + row.effect->words + " (" + row.status.substr(13) + ").";
    verdict.next_protocol = row.effect->split_by;
    d.verdicts.push_back(std::move(verdict));
  }
}

}  // namespace

double noise_chi2(const Diagnosis& d) {
  double white = 0.0;
  for (const estimation::Row& row : d.data->rows()) {
    const auto& noise =
        d.noise
            .channels[static_cast<std::size_t>(row.curve)][static_cast<std::size_t>(row.channel)];
    white += std::pow(noise.scatter_sigma / noise.sigma, 2);
  }
  const double repeated = d.first_screen.expected_chi2;
  const double expected = irreproducible(d) ? std::min(white, repeated) : repeated;
  return expected + chi2_of_steps(d, expected / static_cast<double>(d.data->rows().size()));
}

bool irreproducible(const Diagnosis& d) {
  constexpr double kSmooth = 3.0;
  for (const auto& channels : d.noise.channels)
    for (const estimation::ChannelNoise& noise : channels)
      if (noise.repeat_sigma > kSmooth * noise.scatter_sigma && noise.scatter_sigma > 0.0)
        return true;
  return false;
}

bool lacks_fit_still(const Diagnosis& d) {
  const double expected = noise_chi2(d);
  return (d.last_screen.lack_of_fit > 1.0 || irreproducible(d)) &&
         d.extended.fit.chi2 > 1.1 * expected;
}

const char* verdict_name(VerdictKind kind) {
  switch (kind) {
    case VerdictKind::nothing_found:
      return "NOTHING_FOUND";
    case VerdictKind::named:
      return "NAMED";
    case VerdictKind::ambiguous:
      return "AMBIGUOUS";
    case VerdictKind::sensor:
      return "SENSOR";
    case VerdictKind::not_excited:
      return "NOT_EXCITED";
    case VerdictKind::unexplained:
      return "UNEXPLAINED";
    case VerdictKind::numerical:
      return "NUMERICAL";
  }
  return "";
}

void pass_verdicts(Diagnosis& d, const std::vector<Finding>& findings, const Excitation& excitation,
                   const Options& options) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<const Finding*>> by_effect;
  for (const Finding& f : findings) {
    auto& list = by_effect[f.trial.effect->id];
    if (list.empty()) order.push_back(f.trial.effect->id);
    list.push_back(&f);
  }
  for (const std::string& id : order)
    d.verdicts.push_back(verdict_for(d, id, by_effect[id], excitation, options));
  std::stable_sort(d.verdicts.begin(), d.verdicts.end(),
                   [](const Verdict& a, const Verdict& b) { return a.size > b.size; });
  if (auto steps = quantisation_verdict(d)) d.verdicts.push_back(std::move(*steps));
  add_outliers(d);
  add_unexplained(d, !d.verdicts.empty());
  add_not_excited(d, {order.begin(), order.end()});
}

}  // namespace tenter::diagnosis
