// SPDX-License-Identifier: GPL-3.0-or-later
// Internal friction: Dahl's model with constant sigma_max on any direction (thesis 5.2).
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect internal_friction() {
  Effect effect = described("internal_friction");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    for (const auto& group : place_groups(places(model, excitation, true))) {
      Variant variant;
      variant.words = place_words(group);
      model::Model taken = model;
      for (const Place& place : group) {
        model::Term term =
            new_term(taken, "friction_" + place.name, place.measure, place.angle_rad, "dahl");
        set_parameter(term.law, "a", 0.0);
        set_parameter(term.law, "b", 0.0, true);
        set_parameter(term.law, "tau", 0.1 * place.reach());
        bound_parameter(term.law, "tau", 1e-3 * place.reach(), 3.0 * place.reach());
        taken.terms.push_back(term);
        variant.append.push_back(std::move(term));
      }
      for (const double share : {0.03, 0.12, 0.4}) {
        Setting setting;
        for (std::size_t i = 0; i < group.size(); ++i)
          setting.emplace_back(variant.append[i].id + ".tau", share * group[i].reach());
        variant.grid.push_back(std::move(setting));
      }
      variants.push_back(std::move(variant));
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.has_unloading) return "no run goes back, so nothing lags";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
