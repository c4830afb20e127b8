// SPDX-License-Identifier: GPL-3.0-or-later
// A strain limit: beyond a threshold the stiffness jumps up, below it nothing changes.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect strain_limit() {
  Effect effect = described("strain_limit");
  effect.special_of = "nonlinear_stiffness";
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    std::vector<Place> candidates = places(model, excitation, false);
    // as for nonlinear stiffness: at 45 degrees it would be a coupling in disguise
    if (!has_coupling(model))
      std::erase_if(candidates, [](const Place& place) { return place.name == "diagonal"; });
    std::erase_if(candidates, [&](const Place& place) {
      for (const model::Term& term : model.terms)
        if (term.law.name == "strain_limit" && same_measure(term.strain, place)) return true;
      return false;
    });
    for (const auto& group : place_groups(candidates)) {
      Variant variant;
      variant.words = place_words(group);
      model::Model taken = model;
      for (const Place& place : group) {
        model::Term term =
            new_term(taken, "limit_" + place.name, place.measure, place.angle_rad, "strain_limit");
        set_parameter(term.law, "k", 0.0);
        // below the bound it is a stiffness, above it nothing
        bound_parameter(term.law, "limit", 0.15 * place.reach(), 0.98 * place.reach());
        taken.terms.push_back(term);
        variant.append.push_back(std::move(term));
      }
      for (const double share : {0.35, 0.5, 0.65, 0.8, 0.9}) {
        Setting setting;
        for (std::size_t i = 0; i < group.size(); ++i)
          setting.emplace_back(variant.append[i].id + ".limit", share * group[i].reach());
        variant.grid.push_back(std::move(setting));
      }
      variants.push_back(std::move(variant));
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation&) -> std::optional<std::string> {
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
