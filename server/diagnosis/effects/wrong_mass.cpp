// SPDX-License-Identifier: GPL-3.0-or-later
// A mass of the sheet that is not right: its weight times a factor.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect wrong_mass() {
  Effect effect = described("wrong_mass");
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    // one specimen, however many captures
    auto variants = sheet_capture_variants(model, excitation, "mass_scale");
    if (variants.size() > 1) variants.resize(1);
    return variants;
  };
  effect.variants = [](const model::Model&, const Excitation&) { return std::vector<Variant>(); };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.sheet) return "no sheet was seen";
    if (!e.sheet->hangs) return "nothing weighs anything";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
