// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/take_apart.h"

#include <optional>
#include <string>
#include <utility>

#include "server/diagnosis/prepare.h"
#include "server/diagnosis/trials/exchange.h"
#include "server/diagnosis/trials/model_edit.h"
#include "server/diagnosis/verdicts/verdicts.h"

namespace tenter::diagnosis {
namespace {

/// Two effects where there was one: each of them added to what stands before it.
struct InPlaceOfOne {
  Reference before;  ///< without either
  Trial first, second;
};

/// `second`: added to `current`.
std::optional<InPlaceOfOne> two_in_place_of(const Effect& effect, const Trial& second,
                                            const Diagnosis& d, const Reference& current,
                                            const Excitation& excitation,
                                            const ScreenOptions& options) {
  constexpr double kAll = 0.9;  // of what the one effect leaves
  const Reference both = {second.model, second.fit, second.block_chi2};
  const auto reduced = make_reference(without(both.model, effect.id, d.baseline.model), d.data, {});
  if (!reduced) return std::nullopt;
  auto first = better_in_place_of(effect, d, *reduced, both, excitation, options);
  if (!first) return std::nullopt;
  const double noise = noise_chi2(d);
  const double rows = std::max(current.fit.effective_rows, first->fit.effective_rows);
  if (explained_share(current.fit.chi2, first->fit.chi2, noise) < kAll ||
      information(first->fit.chi2, free_count(first->model), 1, rows) >
          information(current.fit.chi2, free_count(current.model), 0, rows) - kDecisive)
    return std::nullopt;
  const std::string& id = second.effect->id;
  auto alone = make_reference(without(first->model, id, d.baseline.model), d.data, {});
  if (!alone) return std::nullopt;
  auto before =
      make_reference(without(alone->model, first->effect->id, d.baseline.model), d.data, {});
  if (!before) return std::nullopt;
  InPlaceOfOne two = {std::move(*before), *first, second};
  two.first.model = alone->model;
  two.first.fit = alone->fit;
  two.first.block_chi2 = alone->block_chi2;
  two.second.model = std::move(first->model);
  two.second.fit = std::move(first->fit);
  two.second.block_chi2 = std::move(first->block_chi2);
  two.second.objections.clear();
  judge(two.second, *alone, d.data, noise);
  if (!two.second.objections.empty()) return std::nullopt;
  return two;
}

}  // namespace

void take_apart(Diagnosis& d, Reference& current, std::vector<Accepted>& accepted,
                const Excitation& excitation, const ScreenOptions& options,
                const Control& control) {
  if (d.within_form.empty()) return;
  const Trial second = d.within_form.front();
  for (std::size_t i = 0; i < accepted.size() && !control.stop.stop_requested(); ++i) {
    const Effect& effect = *accepted[i].trial.effect;
    if (effect.is_exact || !holds(second.model, effect.id)) continue;
    control.report({"exchange", effect.id, static_cast<int>(i), current.fit.chi2, 0.84});
    auto two = two_in_place_of(effect, second, d, current, excitation, options);
    if (!two) continue;
    const std::string gone = effect.id;
    const std::vector<Trial> rivals = {accepted[i].trial};
    std::erase_if(accepted, [&](const Accepted& other) { return other.trial.effect->id == gone; });
    const Reference alone = reference_of(two->first);
    d.path.push_back(step_of(
        "drop", gone,
        two->first.effect->id + " and " + two->second.effect->id + " do better in its place",
        two->before, d));
    Accepted entry = added_to(two->before, std::move(two->first), d);
    entry.rivals = rivals;
    d.path.push_back(step_of("add", entry.trial.effect->id, entry.trial.variant.words, alone, d));
    accepted.push_back(std::move(entry));
    current = reference_of(two->second);
    d.path.push_back(step_of("add", two->second.effect->id, two->second.variant.words, current, d));
    accepted.push_back(added_to(alone, std::move(two->second), d));
    d.within_form.clear();
    return;
  }
}

}  // namespace tenter::diagnosis
