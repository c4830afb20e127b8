// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/verdicts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "server/diagnosis/checks/lattice.h"
#include "server/diagnosis/next/curve_bench.h"
#include "server/diagnosis/prepare.h"
#include "server/diagnosis/trials/model_edit.h"
#include "server/diagnosis/verdicts/effect_size.h"
#include "server/diagnosis/verdicts/neighbours.h"
#include "server/diagnosis/verdicts/score.h"
#include "server/diagnosis/verdicts/verdict_words.h"

namespace tenter::diagnosis {
namespace {

/// The extended model with another effect in the place of one that was found.
struct Swapped {
  std::string id;
  Reference fitted;
  bool is_equal = false;  ///< twice the log evidence that speaks against it is small
};

std::vector<Swapped> swapped_rivals(const Diagnosis& d, const std::string& effect,
                                    const std::vector<Trial>& rivals) {
  std::vector<Swapped> all;
  std::set<std::string> tried;
  for (const Trial& rival : rivals) {
    if (tried.contains(rival.effect->id) || rival.effect->id == effect) continue;
    if (says_nothing_against(rival.effect->id, effect)) continue;
    if (holds(d.extended.model, rival.effect->id)) continue;
    auto swapped = make_reference(
        with_rival(without(d.extended.model, effect, d.baseline.model), rival), d.data, {});
    if (!swapped) continue;
    const bool is_equal = evidence_against(*swapped, d.extended) < kDecisive;
    tried.insert(rival.effect->id);
    all.push_back({rival.effect->id, std::move(*swapped), is_equal});
  }
  return all;
}

/// What to capture next: the pull that splits the effect from its alternatives, where one does;
/// else the protocol of the effect's row.
void propose_next(const Diagnosis& d, const Effect& effect, const std::vector<Swapped>& swapped,
                  const RigLimits& rig, Verdict& verdict) {
  verdict.next_protocol = effect.split_by;
  std::vector<const Reference*> causes = {&d.extended};
  const std::vector<std::string> split = to_be_split(effect.id, verdict.alternatives);
  for (const std::string& id : split)
    for (const Swapped& other : swapped)
      if (other.id == id) causes.push_back(&other.fitted);
  if (causes.size() <= split.size()) return;
  verdict.design = design_next(causes, curve_bench(causes, *d.data, rig), rig,
                               question_of(effect.id, verdict.alternatives));
  if (verdict.design) describe(*verdict.design, *verdict.next_protocol);
}

Verdict verdict_for(const Diagnosis& d, const std::string& id,
                    const std::vector<const Finding*>& findings, const Excitation& excitation,
                    const Options& options) {
  const Effect& effect = *find_effect(id);
  Verdict verdict;
  std::vector<const Trial*> trials;
  std::vector<Trial> rivals;
  for (const Finding* f : findings) {
    trials.push_back(&f->trial);
    rivals.insert(rivals.end(), f->rivals.begin(), f->rivals.end());
  }
  const std::vector<Swapped> swapped = swapped_rivals(d, id, rivals);
  for (const Swapped& other : swapped)
    if (other.is_equal) verdict.alternatives.push_back(other.id);
  add_untold(effect, excitation, verdict.alternatives);
  auto reduced = make_reference(without(d.extended.model, id, d.baseline.model), d.data, {});
  const SizeInterval size =
      effect_size(*d.data, reduced ? reduced->fit : d.baseline.fit, d.extended.fit, options.seed);
  put_in_words(effect, trials, size, size.of_force ? "force" : "free stretch", "this capture",
               d.data->block_count(), verdict);
  if (!verdict.alternatives.empty()) propose_next(d, effect, swapped, options.rig, verdict);
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

/// Where nothing could be left out nothing is proven: what explains all alike is a group, and what
/// alone would explain it is no more than a word beside UNEXPLAINED. The fit of the group's first;
/// none: there is no group.
const estimation::FitResult* add_unproven(Diagnosis& d, const Options& options) {
  constexpr std::size_t kMostAlternatives = 2;
  if (d.unproven.empty()) return nullptr;
  const Trial& best = d.unproven.front();
  Verdict verdict;
  for (const Trial& other : d.unproven) {
    const std::string& id = other.effect->id;
    if (other.effect == best.effect || says_nothing_against(id, best.effect->id) ||
        std::ranges::count(verdict.alternatives, id) > 0)
      continue;
    if (evidence_against({other.model, other.fit, {}}, {best.model, best.fit, {}}) < kDecisive)
      verdict.alternatives.push_back(id);
  }
  if (verdict.alternatives.empty() || verdict.alternatives.size() > kMostAlternatives)
    return nullptr;
  const SizeInterval size = effect_size(*d.data, d.baseline.fit, best.fit, options.seed);
  put_in_words(*best.effect, {&best}, size, size.of_force ? "force" : "free stretch",
               "this capture", d.data->block_count(), verdict);
  verdict.words += " Nothing could be left out to prove it: pull again.";
  verdict.next_protocol = best.effect->split_by;
  d.verdicts.push_back(std::move(verdict));
  return &best.fit;
}

/// Neither repeats nor the captures say how large the noise is.
bool knows_only_neighbours(const estimation::Noise& noise) {
  for (const auto& channels : noise.channels)
    for (const estimation::ChannelNoise& channel : channels)
      if (channel.source != estimation::NoiseSource::scatter) return false;
  return true;
}

/// `last`: of the model that explains most.
void add_unexplained(Diagnosis& d, const estimation::FitResult& last, bool anything_found) {
  const double expected = noise_chi2(d);
  const double missed = std::max(0.0, d.baseline.fit.chi2 - expected);
  const double left = std::max(0.0, last.chi2 - expected);
  d.unexplained_share = missed > 0.0 ? std::min(1.0, left / missed) : 0.0;
  const bool lacks_fit = lacks_fit_still(d, last);
  if (!lacks_fit) {
    d.unexplained_share = 0.0;
    if (anything_found) return;
    d.verdicts.push_back(nothing_found(d.noise_floor));
    return;
  }
  Verdict verdict = unexplained(d, score_of(*d.data, d.data->rows(), last.residuals, -1).error);
  if (!anything_found && !d.unproven.empty())
    verdict.words += " It could be " + d.unproven.front().effect->words +
                     ", but nothing could be left out to prove it: pull again.";
  if (!anything_found && knows_only_neighbours(d.noise))
    verdict.words +=
        " Noise that neighbouring readings share would look like this too: a repeat would tell.";
  if (irreproducible(d))
    verdict.words +=
        " Repeats of the same path differ smoothly by far more than neighbouring samples scatter.";
  d.verdicts.push_back(std::move(verdict));
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

bool misses_more_than_noise(const Diagnosis& d, const estimation::FitResult& last) {
  // of the noise's power: less, noise that is not alike everywhere has too
  constexpr double kLeast = 0.125;
  return (d.last_screen.lack_of_fit > 1.0 || irreproducible(d)) &&
         last.chi2 > (1.0 + kLeast) * noise_chi2(d);
}

bool lacks_fit_still(const Diagnosis& d, const estimation::FitResult& last) {
  constexpr double kAlike = 2.33;  // 1 % of white noise
  return misses_more_than_noise(d, last) &&
         (!knows_only_neighbours(d.noise) ||
          neighbours_alike(d.data->rows(), last.residuals) > kAlike);
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
  const estimation::FitResult* group = findings.empty() ? add_unproven(d, options) : nullptr;
  add_outliers(d);
  add_unexplained(d, group != nullptr ? *group : d.extended.fit, !d.verdicts.empty());
  add_not_excited(d, {order.begin(), order.end()}, [](const Effect&) { return true; });
}

}  // namespace tenter::diagnosis
