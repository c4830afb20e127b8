// SPDX-License-Identifier: GPL-3.0-or-later
// A rest shape that is not flat: a constant moment on bending.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect rest_shape() {
  Effect effect = described("rest_shape");
  effect.sheet_variants = [](const model::Model& model, const Excitation&) {
    std::vector<Variant> variants;
    Variant both;
    both.words = "curled along both";
    for (const char* measure : {"bend_u", "bend_v"}) {
      bool known = false;
      for (const model::Term& term : model.terms)
        known = known || (term.strain.name == measure && term.law.name == "constant_stress");
      if (known) continue;
      Variant variant;
      variant.words =
          measure == std::string("bend_u") ? "curled along the weft" : "curled along the warp";
      model::Term term =
          new_term(model, std::string("curl_") + measure, measure, 0.0, "constant_stress");
      set_parameter(term.law, "c", 0.0);
      both.append.push_back(term);
      variant.append.push_back(std::move(term));
      variants.push_back(std::move(variant));
    }
    if (both.append.size() == 2) variants.push_back(std::move(both));
    return variants;
  };
  effect.variants = [](const model::Model&, const Excitation&) { return std::vector<Variant>(); };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.sheet) return "no sheet was seen";
    for (const char* measure : {"bend_u", "bend_v"}) {
      const auto [lo, hi] = range_of(e, {measure, 0.0});
      if (hi - lo > 1.0) return std::nullopt;
    }
    return "nothing is free to bend";
  };
  return effect;
}

}  // namespace tenter::diagnosis
