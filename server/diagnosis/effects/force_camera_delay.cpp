// SPDX-License-Identifier: GPL-3.0-or-later
// Clocks apart: the force is that of a moment before (or after) the strain's.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect force_camera_delay() {
  Effect effect = described("force_camera_delay");
  effect.needs_rate = true;
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    for (const model::SensorCorrection& c : model.corrections)
      if (c.type == "delay") return variants;
    Variant variant;
    variant.words = "all channels of force";
    model::SensorCorrection correction = new_correction(model, "delay", "");
    // a clock that is off by more than a twentieth of a run would have been noticed
    correction.parameters[0].lower = -0.05 * excitation.longest_s;
    correction.parameters[0].upper = 0.05 * excitation.longest_s;
    variant.corrections.push_back(std::move(correction));
    variants.push_back(std::move(variant));
    return variants;
  };
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    for (const model::SensorCorrection& c : model.corrections)
      if (c.type == "delay") return variants;
    Variant variant;
    variant.words = "all channels of force";
    variant.corrections.push_back(new_sheet_correction(model, "delay", "", ""));
    variant.corrections[0].parameters[0].lower = -0.05 * excitation.longest_s;
    variant.corrections[0].parameters[0].upper = 0.05 * excitation.longest_s;
    variants.push_back(std::move(variant));
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (e.sheet && e.sheet->forces.empty()) return "no force was measured";
    if (!e.has_clock) return "no time was recorded";
    if (!e.has_unloading && !e.splits_rate())
      return "one rate and no way back: a delay looks like a bent curve";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
