// SPDX-License-Identifier: GPL-3.0-or-later
// Poisson coupling: a stretch along one direction pulls on the other.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect poisson_coupling() {
  Effect effect = described("poisson_coupling");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    const auto has = [&](const std::string& measure) {
      for (const model::Term& term : model.terms)
        if (term.strain.name == measure) return true;
      return false;
    };
    const auto append = [&](const std::string& words, const std::string& measure,
                            const std::string& law, const std::string& parameter) {
      if (has(measure)) return;
      Variant variant;
      variant.words = words;
      model::Term term = new_term(model, "coupling", measure, 0.0, law);
      set_parameter(term.law, parameter, 0.0);
      variant.append.push_back(std::move(term));
      variants.push_back(std::move(variant));
    };
    const bool isotropic = has("green_trace");
    if (!isotropic) append("product of the Green strains", "green_pair", "bilinear", "c");
    if (excitation.large_strain) {
      append("product of the engineering strains", "soft_pair", "bilinear", "c");
      append("change of area", "area", "linear", "k");
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (e.sheet) return std::nullopt;  // its points say how it narrows
    for (const auto& c : e.curves)
      for (const auto& channel : c.channels)
        if (!channel.is_stress || e.stress_components.size() > 1) return std::nullopt;
    return "neither a transverse force nor a transverse stretch was measured";
  };
  return effect;
}

}  // namespace tenter::diagnosis
