// SPDX-License-Identifier: GPL-3.0-or-later
// Points beside hidden ones, seen nearer to the cameras than they are.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect occlusion_bias() {
  Effect effect = described("occlusion_bias");
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    auto variants = sheet_capture_variants(model, excitation, "occlusion_bias");
    if (variants.size() > 1) variants.resize(1);
    // how large the cameras' patches are is not known
    for (Variant& variant : variants)
      for (const double reach : {1.0, 1.25, 1.5, 2.0, 2.5, 3.0})
        variant.grid.push_back({{variant.corrections.front().id + ".reach", reach}});
    return variants;
  };
  effect.variants = [](const model::Model&, const Excitation&) { return std::vector<Variant>(); };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.sheet) return "no sheet was seen";
    if (!e.sheet->has_hidden) return "every point is seen in every frame";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
