// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/heterogeneity/material_samples.h"

#include <algorithm>

namespace tenter::estimation {
namespace {

std::vector<std::string> chosen(const model::Model& base, const MaterialSamples& samples) {
  if (!samples.terms.empty()) return samples.terms;
  std::vector<std::string> all;
  all.reserve(base.terms.size());
  for (const model::Term& term : base.terms) all.push_back(term.id);
  return all;
}

std::string at_sample(const std::string& id, int sample) {
  return id + "_" + std::to_string(sample + 1);
}

Expected<void> check(const model::Model& base, const MaterialSamples& samples) {
  if (samples.field.sample_count() < 1 || !(samples.field.width_m > 0.0))
    return bad_input("material samples need positions and a width above zero");
  for (const std::string& id : chosen(base, samples)) {
    const auto term = std::find_if(base.terms.begin(), base.terms.end(),
                                   [&](const model::Term& t) { return t.id == id; });
    if (term == base.terms.end()) return bad_input("the model has no term \"" + id + "\"");
    if (term->support.name != "everywhere")
      return bad_input("term \"" + id + "\" acts at samples already");
  }
  if (!base.limits.empty()) return bad_input("a model with energy limits cannot be given samples");
  return {};
}

}  // namespace

MaterialSamples even_samples(int count_u, int count_v, double length_u_m, double length_v_m) {
  MaterialSamples samples;
  samples.field.id = "material";
  const double du = length_u_m / count_u;
  const double dv = length_v_m / count_v;
  samples.field.width_m = 0.5 * std::max(du, dv);
  for (int j = 0; j < count_v; ++j)
    for (int i = 0; i < count_u; ++i) {
      samples.field.positions_m.push_back((i + 0.5) * du);
      samples.field.positions_m.push_back((j + 0.5) * dv);
    }
  return samples;
}

Expected<model::Model> with_samples(const model::Model& base, const MaterialSamples& samples) {
  if (auto ok = check(base, samples); !ok) return tl::unexpected(ok.error());
  const std::vector<std::string> ids = chosen(base, samples);
  model::Model result = base;
  result.terms.clear();
  result.fields.push_back(samples.field);
  for (const model::Term& term : base.terms) {
    if (std::find(ids.begin(), ids.end(), term.id) == ids.end()) {
      result.terms.push_back(term);
      continue;
    }
    for (int k = 0; k < samples.field.sample_count(); ++k) {
      model::Term copy = term;
      copy.id = at_sample(term.id, k);
      copy.support = {"rbf", samples.field.id, k + 1};
      result.terms.push_back(std::move(copy));
    }
  }
  for (const model::StrainRange& range : base.strain_ranges)
    if (std::find(ids.begin(), ids.end(), range.term) != ids.end())
      for (int k = 0; k < samples.field.sample_count(); ++k)
        result.strain_ranges.push_back({at_sample(range.term, k), range.lo, range.hi});
  return result;
}

Expected<ParameterTies> background_ties(const model::Model& expanded, const model::Model& base,
                                        const MaterialSamples& samples,
                                        const std::vector<int>& released) {
  std::vector<std::vector<std::string>> groups;
  for (const std::string& id : chosen(base, samples)) {
    std::vector<std::string> group;
    for (int k = 0; k < samples.field.sample_count(); ++k)
      if (std::find(released.begin(), released.end(), k) == released.end())
        group.push_back(at_sample(id, k));
    if (group.size() > 1) groups.push_back(std::move(group));
  }
  return tie_terms(expanded, groups);
}

std::vector<int> parameters_of_sample(const model::Model& expanded, int sample) {
  std::vector<int> result;
  int first = 0;
  for (const model::Term& term : expanded.terms) {
    const auto count = static_cast<int>(term.law.parameters.size());
    if (term.support.name == "rbf" && term.support.sample == sample + 1)
      for (int j = 0; j < count; ++j)
        if (!term.law.parameters[static_cast<std::size_t>(j)].fixed) result.push_back(first + j);
    first += count;
  }
  return result;
}

}  // namespace tenter::estimation
