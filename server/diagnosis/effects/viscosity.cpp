// SPDX-License-Identifier: GPL-3.0-or-later
// Viscosity: a Maxwell or a Kelvin-Voigt element beside the elastic terms.
#include <cmath>

#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect viscosity() {
  Effect effect = described("viscosity");
  effect.needs_rate = true;
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    const double shortest = std::max(excitation.shortest_step_s, 1e-4 * excitation.longest_s);
    const double ratio = excitation.longest_s / shortest;
    for (const auto& group : place_groups(places(model, excitation, true))) {
      Variant maxwell;
      maxwell.words = "Maxwell, " + place_words(group);
      Variant voigt;
      voigt.words = "Kelvin-Voigt, " + place_words(group);
      model::Model taken = model;
      for (const Place& place : group) {
        model::Term term =
            new_term(taken, "viscous_" + place.name, place.measure, place.angle_rad, "maxwell");
        set_parameter(term.law, "k", 0.0);
        bound_parameter(term.law, "relaxation_time", 0.3 * shortest, 10.0 * excitation.longest_s);
        maxwell.append.push_back(term);
        taken.terms.push_back(std::move(term));
        term = new_term(model, "dashpot_" + place.name, place.measure, place.angle_rad,
                        "kelvin_voigt");
        set_parameter(term.law, "eta", 0.0);
        voigt.append.push_back(std::move(term));
      }
      constexpr int kTimes = 5;
      for (int i = 0; i < kTimes; ++i) {
        Setting setting;
        for (const model::Term& term : maxwell.append)
          setting.emplace_back(term.id + ".relaxation_time",
                               shortest * std::pow(ratio, (i + 0.7) / kTimes));
        maxwell.grid.push_back(std::move(setting));
      }
      variants.push_back(std::move(maxwell));
      variants.push_back(std::move(voigt));
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.has_unloading && !e.splits_rate()) return "one rate, no hold and no way back";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
