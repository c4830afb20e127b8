// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/screening/shortlist.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "server/diagnosis/trials/trial.h"

namespace tenter::diagnosis {

std::vector<Candidate> shortlist(const Screen& screen, const estimation::FitResult& fit,
                                 std::size_t effects) {
  std::vector<std::pair<double, const Candidate*>> order;
  for (const Candidate& c : screen.candidates) {
    if (c.ratio <= 1.0) continue;
    const double left = std::max(fit.chi2 - c.within, 1e-3 * fit.chi2);
    order.emplace_back(information(left, c.df, 0, fit.effective_rows), &c);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Candidate> chosen;
  std::map<const Effect*, std::set<std::string>> taken;
  std::map<std::pair<const Effect*, std::size_t>, int> of_size;
  for (const auto& [score, c] : order) {
    const std::size_t parts =
        c->variant.append.size() + c->variant.replace.size() + c->variant.corrections.size();
    if (!taken.contains(c->effect) && taken.size() >= effects) continue;
    if (taken[c->effect].contains(c->variant.words)) continue;
    if (of_size[{c->effect, parts}] >= (parts <= 1 ? 3 : 1)) continue;
    ++of_size[{c->effect, parts}];
    taken[c->effect].insert(c->variant.words);
    chosen.push_back(*c);
  }
  return chosen;
}

}  // namespace tenter::diagnosis
