// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/staged/splines/strain_histogram.h"

#include <algorithm>

namespace tenter::estimation {

void StrainHistogram::sort() {
  std::sort(samples_.begin(), samples_.end());
  weight_ = 0.0;
  for (const auto& [strain, weight] : samples_) weight_ += weight;
}

void StrainHistogram::merge(const StrainHistogram& other) {
  samples_.insert(samples_.end(), other.samples_.begin(), other.samples_.end());
  sort();
}

double StrainHistogram::quantile(double share) const {
  double below = 0.0;
  for (const auto& [strain, weight] : samples_) {
    below += weight;
    if (below >= share * weight_) return strain;
  }
  return samples_.empty() ? 0.0 : samples_.back().first;
}

std::pair<double, double> StrainHistogram::range(double outliers) const {
  return {quantile(outliers), quantile(1.0 - outliers)};
}

std::vector<double> StrainHistogram::bins(double lo, double hi, int count) const {
  std::vector<double> share(static_cast<std::size_t>(count), 0.0);
  for (const auto& [strain, weight] : samples_) {
    if (!(strain >= lo && strain <= hi && weight_ > 0.0)) continue;
    const int bin = std::min(count - 1, static_cast<int>((strain - lo) / (hi - lo) * count));
    share[static_cast<std::size_t>(bin)] += weight / weight_;
  }
  return share;
}

std::vector<StrainHistogram> strain_histograms(const mechanics::MeshModel& model,
                                               const std::vector<mechanics::State>& states,
                                               const std::vector<double>& weights) {
  std::vector<StrainHistogram> result(static_cast<std::size_t>(model.term_count()));
  std::vector<mechanics::TermStrains> strains;
  for (std::size_t s = 0; s < states.size(); ++s) {
    const double weight = weights.empty() ? 1.0 : weights[s];
    if (model.term_strains(states[s].x, strains) != mechanics::AssemblyStatus::ok) continue;
    for (const mechanics::TermStrains& of_term : strains) {
      const auto per = static_cast<std::size_t>(of_term.strains);
      for (std::size_t k = 0; k < of_term.strain.size(); ++k)
        result[static_cast<std::size_t>(of_term.term)].add(of_term.strain[k],
                                                           weight * of_term.measure[k / per]);
    }
  }
  for (StrainHistogram& histogram : result) histogram.sort();
  return result;
}

void append(std::vector<StrainHistogram>& to, const std::vector<StrainHistogram>& from) {
  if (to.size() < from.size()) to.resize(from.size());
  for (std::size_t t = 0; t < from.size(); ++t) to[t].merge(from[t]);
}

void merge_tied(const std::vector<model::Term>& terms,
                const std::vector<std::vector<std::string>>& groups,
                std::vector<StrainHistogram>& of_terms) {
  for (const auto& group : groups) {
    std::vector<std::size_t> members;
    StrainHistogram all;
    for (std::size_t t = 0; t < terms.size(); ++t)
      if (std::find(group.begin(), group.end(), terms[t].id) != group.end()) {
        members.push_back(t);
        all.merge(of_terms[t]);
      }
    for (const std::size_t t : members) of_terms[t] = all;
  }
}

}  // namespace tenter::estimation
