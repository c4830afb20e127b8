// SPDX-License-Identifier: GPL-3.0-or-later
// Plastic set: the rest length moves with each new maximum and nothing else moves it.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect plastic_set() {
  Effect effect = described("plastic_set");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants =
        onset_variants(model, excitation,
                       {"set", "plastic_set", "c", "yield_strain", {0.001, 0.3, 0.6}, 1e-3, 1.5});
    // a rest length that moves also moves what its direction does to the other
    for (const char* direction : {"weft", "warp"}) {
      const bool is_weft = direction == std::string("weft");
      const double reach = is_weft ? excitation.weft : excitation.warp;
      if (reach < 1e-4) continue;
      Variant variant;
      variant.words = std::string(direction) + ", with its coupling";
      model::Term term =
          new_term(model, std::string("set_") + direction, is_weft ? "green_pair" : "green_pair_vu",
                   0.0, "plastic_set_coupled");
      set_parameter(term.law, "c", 0.0);
      set_parameter(term.law, "coupling", 0.0);
      bound_parameter(term.law, "yield_strain", 1e-3 * reach, 1.5 * reach);
      for (const double share : {0.001, 0.3, 0.6})
        variant.grid.push_back({{term.id + ".yield_strain", share * reach}});
      variant.append.push_back(std::move(term));
      variants.push_back(std::move(variant));
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.has_unloading && !e.has_repeated_loading) return "no strain is reached twice";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
