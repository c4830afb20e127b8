// SPDX-License-Identifier: GPL-3.0-or-later
// Friction of a cord over its pulley: the cell shows T (1 + mu) while the cord is pulled and
// T (1 - mu) while it is let back.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect cord_friction() {
  Effect effect = described("cord_friction");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    return channel_variants(model, excitation, "cord_friction");
  };
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    return sheet_channel_variants(model, excitation, "cord_friction");
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (e.sheet && e.sheet->forces.empty()) return "no force was measured";
    if (!e.has_unloading) return "no run goes back, so no cord turns";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
