// SPDX-License-Identifier: GPL-3.0-or-later
// Load cells: offset, gain and drift of one channel of force.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {
namespace {

Effect load_cell(const std::string& id, const std::string& type) {
  Effect effect = described(id);
  effect.variants = [type](const model::Model& model, const Excitation& excitation) {
    return channel_variants(model, excitation, type);
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (e.sheet && e.sheet->forces.empty()) return "no force was measured";
    return std::nullopt;
  };
  effect.sheet_variants = [type](const model::Model& model, const Excitation& excitation) {
    return sheet_channel_variants(model, excitation, type);
  };
  return effect;
}

}  // namespace

Effect load_cell_offset() {
  Effect effect = load_cell("load_cell_offset", "offset");
  effect.is_exact = true;
  return effect;
}

Effect load_cell_gain() {
  Effect effect = load_cell("load_cell_gain", "gain");
  effect.is_exact = true;
  return effect;
}

Effect load_cell_drift() {
  Effect effect = load_cell("load_cell_drift", "drift");
  effect.needs_rate = true;
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (e.sheet && e.sheet->forces.empty()) return "no force was measured";
    if (!e.has_clock) return "no time was recorded";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
