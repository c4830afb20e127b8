// SPDX-License-Identifier: GPL-3.0-or-later
// First-cycle softening (Mullins, settling): only the first loading to each new maximum feels the
// whole stiffness.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect first_cycle_softening() {
  Effect effect = described("first_cycle_softening");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    for (const double power : {1.0, 3.0}) {
      auto along =
          onset_variants(model, excitation,
                         {"softening", "softening", "k", "strain_scale", {0.05, 0.25}, 1e-3, 2.0});
      for (Variant& variant : along) {
        variant.words +=
            power > 1.0 ? ", growing with the cube of strain" : ", in proportion to strain";
        for (model::Term& term : variant.append) set_parameter(term.law, "power", power, true);
        variants.push_back(std::move(variant));
      }
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.has_repeated_loading) return "no strain is loaded twice on one specimen";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
