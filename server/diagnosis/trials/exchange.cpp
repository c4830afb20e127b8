// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/trials/exchange.h"

#include <algorithm>

#include "server/diagnosis/screening/shortlist.h"
#include "server/diagnosis/trials/model_edit.h"

namespace tenter::diagnosis {
namespace {

constexpr double kClear = 2.0;  // of the criterion, on the scale of twice a log likelihood

}  // namespace

std::optional<Trial> better_neighbour(const Diagnosis& d, const Effect& effect,
                                      const Reference& reduced, const Reference& current,
                                      const Excitation& excitation, const ScreenOptions& options) {
  ScreenOptions narrowed = options;
  narrowed.effects.clear();
  for (const std::string& id : effect.mistaken_for) {
    const bool may_be_tried =
        options.effects.empty() || std::ranges::count(options.effects, id) > 0;
    if (may_be_tried && find_effect(id) && !holds(current.model, id))
      narrowed.effects.push_back(id);
  }
  if (narrowed.effects.empty()) return std::nullopt;
  const Screen found = screen(reduced.model, reduced.fit, d.data, d.noise, excitation, narrowed);
  std::optional<Trial> best;
  const auto criterion = [&](const estimation::FitResult& fit, const model::Model& model) {
    const double rows = std::max(current.fit.effective_rows, reduced.fit.effective_rows);
    return information(fit.chi2, free_count(model), 0, rows);
  };
  double least = criterion(current.fit, current.model) - kClear;
  for (const Candidate& candidate : shortlist(found, reduced.fit, narrowed.effects.size())) {
    Trial trial = refit(candidate, reduced, d.data);
    if (!trial.fit.usable || criterion(trial.fit, trial.model) >= least) continue;
    judge(trial, reduced, d.data, found.expected_chi2);
    if (!trial.objections.empty()) continue;
    least = criterion(trial.fit, trial.model);
    best = std::move(trial);
  }
  return best;
}

}  // namespace tenter::diagnosis
