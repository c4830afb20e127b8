// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trials/exchange.h"

#include <algorithm>

#include "server/diagnosis/screening/shortlist.h"
#include "server/diagnosis/trials/model_edit.h"

namespace tenter::diagnosis {
namespace {

constexpr double kClear = 2.0;     // of the criterion, on the scale of twice a log likelihood
constexpr std::size_t kTried = 3;  // of those that the effect is not mistaken for

}  // namespace

std::optional<Trial> better_in_place_of(const Effect& effect, const Diagnosis& d,
                                        const Reference& reduced, const Reference& current,
                                        const Excitation& excitation,
                                        const ScreenOptions& options) {
  Screen found = screen(reduced.model, reduced.fit, d.data, d.noise, excitation, options);
  std::erase_if(found.candidates,
                [&](const Candidate& c) { return holds(current.model, c.effect->id); });
  const auto is_neighbour = [&](const Candidate& c) {
    return std::ranges::count(effect.mistaken_for, c.effect->id) > 0;
  };
  Screen neighbours = found;
  std::erase_if(neighbours.candidates, [&](const Candidate& c) { return !is_neighbour(c); });
  std::erase_if(found.candidates, is_neighbour);
  std::vector<Candidate> tried =
      shortlist(neighbours, reduced.fit, std::max<std::size_t>(1, effect.mistaken_for.size()));
  for (Candidate& other : shortlist(found, reduced.fit, kTried)) tried.push_back(std::move(other));

  std::optional<Trial> best;
  const auto criterion = [&](const estimation::FitResult& fit, const model::Model& model) {
    const double rows = std::max(current.fit.effective_rows, reduced.fit.effective_rows);
    return information(fit.chi2, free_count(model), 0, rows);
  };
  const double now = criterion(current.fit, current.model);
  double least = now;
  for (const Candidate& candidate : tried) {
    Trial trial = refit(candidate, reduced, d.data);
    if (!trial.fit.usable) continue;
    const double then = criterion(trial.fit, trial.model);
    if (then >= least || then > now - (is_neighbour(candidate) ? kClear : kDecisive)) continue;
    judge(trial, reduced, d.data, found.expected_chi2);
    if (!trial.objections.empty()) continue;
    least = then;
    best = std::move(trial);
  }
  return best;
}

}  // namespace tenter::diagnosis
