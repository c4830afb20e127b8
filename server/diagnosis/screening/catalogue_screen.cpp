// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screening/catalogue_screen.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace tenter::diagnosis {
namespace {

/// Grids can be long, and a candidate is one point of them.
Variant without_grids(const Variant& variant) {
  Variant copy;
  copy.words = variant.words;
  copy.append = variant.append;
  copy.replace = variant.replace;
  copy.unfix = variant.unfix;
  copy.corrections = variant.corrections;
  copy.parts_are_one = variant.parts_are_one;
  copy.fields = variant.fields;
  copy.searched = variant.searched;
  return copy;
}

/// Points of the finer grid between the neighbours of the coarse point that was liked best.
std::vector<Setting> around(const Variant& variant, const Setting& best) {
  std::vector<Setting> near;
  for (const Setting& setting : variant.finer) {
    bool inside = true;
    for (const auto& [address, value] : best) {
      double lower = -1e300;
      double upper = 1e300;
      for (const Setting& coarse : variant.grid)
        for (const auto& [other, at] : coarse) {
          if (other != address) continue;
          if (at < value) lower = std::max(lower, at);
          if (at > value) upper = std::min(upper, at);
        }
      for (const auto& [other, at] : setting)
        if (other == address && (at < lower || at > upper)) inside = false;
    }
    if (inside) near.push_back(setting);
  }
  return near;
}

/// Tests every entry and adds it to the candidates; `largest` collects each twin's largest u.
bool add_candidates(const Gathering& gathering, const ColumnSource& source,
                    const ScreenOptions& options, std::vector<double>& largest,
                    std::vector<Candidate>& candidates) {
  Ground ground;
  Eigen::MatrixXd columns;
  if (!source(gathering, ground, columns)) return false;
  for (const Columns& entry : gathering.entries()) {
    const auto count = static_cast<Eigen::Index>(entry.columns.size());
    Eigen::MatrixXd z(columns.rows(), count);
    for (Eigen::Index c = 0; c < count; ++c)
      z.col(c) = columns.col(gathering.place(entry.columns[static_cast<std::size_t>(c)]));
    auto tested = score_test(ground, z, entry.least, &largest);
    if (!tested) continue;
    Candidate candidate;
    candidate.effect = entry.effect;
    candidate.variant = without_grids(*entry.variant);
    candidate.source = entry.variant;
    candidate.point = entry.setting;
    candidate.setting = entry.setting;
    candidate.gain = tested->gain;
    candidate.within = tested->within;
    candidate.df = tested->df;
    candidate.ratio = tested->u;
    candidate.direction = std::move(tested->direction);
    if (options.keep_spaces) candidate.space = std::move(tested->space);
    for (std::size_t c = 0; c < entry.addresses.size(); ++c) {
      const double change =
          std::max(entry.least[c], tested->amplitudes[static_cast<Eigen::Index>(c)]);
      candidate.setting.emplace_back(entry.addresses[c], entry.off[c] + change);
    }
    candidates.push_back(std::move(candidate));
  }
  return true;
}

}  // namespace

void screen_catalogue(const model::Model& fitted, const Excitation& excitation,
                      const ColumnSource& source, const ScreenOptions& options, Screen& result) {
  Gathering gathering(fitted);
  std::vector<std::vector<Variant>> variants;  // kept alive: the entries point into it
  const std::vector<Effect>& effects = excitation.sheet ? sheet_catalogue() : catalogue();
  variants.reserve(effects.size());
  std::map<const Effect*, ScreenRow> table;
  for (const Effect& effect : effects) {
    ScreenRow row;
    row.effect = &effect;
    variants.emplace_back();
    if (!options.effects.empty() && !std::ranges::count(options.effects, effect.id)) {
      row.status = "not asked for";
    } else if (const auto why = why_not_excited(effect, fitted, excitation)) {
      row.status = "not excited: " + *why;
    } else {
      variants.back() = variants_of(effect, fitted, excitation);
      row.status = variants.back().empty() ? "in the model" : "hides in the model's own parameters";
    }
    for (const Variant& variant : variants.back()) {
      if (variant.grid.empty()) gathering.add(effect, variant, {});
      for (const Setting& setting : variant.grid) gathering.add(effect, variant, setting);
    }
    table[&effect] = row;
  }
  std::vector<double> largest(static_cast<std::size_t>(options.null_twins), 0.0);
  if (!add_candidates(gathering, source, options, largest, result.candidates)) return;
  const auto by_ratio = [](const Candidate& a, const Candidate& b) { return a.ratio > b.ratio; };
  std::stable_sort(result.candidates.begin(), result.candidates.end(), by_ratio);

  // a finer look at the two likeliest variants of each effect that has one
  Gathering fine(fitted);
  std::map<const Effect*, std::set<std::string>> looked_at;
  for (const Candidate& c : result.candidates) {
    if (c.source->finer.empty() || looked_at[c.effect].size() >= 2) continue;
    if (!looked_at[c.effect].insert(c.variant.words).second) continue;
    for (const Setting& setting : around(*c.source, c.point))
      fine.add(*c.effect, *c.source, setting);
  }
  if (!fine.entries().empty()) add_candidates(fine, source, options, largest, result.candidates);

  const double threshold = percentile(largest, 0.95);
  for (Candidate& c : result.candidates) {
    c.ratio /= threshold;
    c.source = nullptr;
    ScreenRow& row = table[c.effect];
    if (row.status == "screened" && row.gain / std::max(1, row.df) >= c.gain / c.df) continue;
    row.status = "screened";
    row.gain = c.gain;
    row.df = c.df;
    row.ratio = c.ratio;
    row.grid = c.setting;
  }
  std::stable_sort(result.candidates.begin(), result.candidates.end(), by_ratio);
  for (const Effect& effect : effects) result.table.push_back(table[&effect]);
  std::stable_sort(result.table.begin(), result.table.end(),
                   [](const ScreenRow& a, const ScreenRow& b) { return a.ratio > b.ratio; });
}

}  // namespace tenter::diagnosis
