// SPDX-License-Identifier: GPL-3.0-or-later
// Clocks apart: the force is that of a moment before (or after) the strain's.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect force_camera_delay() {
  Effect effect;
  effect.id = "force_camera_delay";
  effect.words = "a delay between the clocks of force and strain";
  effect.kind = Effect::Kind::sensor;
  effect.needs_rate = true;
  effect.mistaken_for = {"viscosity", "internal_friction"};
  effect.split_by = {"hold_and_blank_run",
                     "A hold after a fast ramp, and a blank run with a spring of steel in the place of the specimen: a "
                     "delay does not relax and stays with the rig.",
                     {{"ramp", "as fast as the rig can"}, {"hold", "60 s"}, {"blank", "the same with a steel spring"}}};
  effect.variants = [](const model::Model& model, const Excitation&) {
    std::vector<Variant> variants;
    for (const model::SensorCorrection& c : model.corrections)
      if (c.type == "delay") return variants;
    Variant variant;
    variant.words = "all channels of force";
    variant.corrections.push_back(new_correction(model, "delay", ""));
    variants.push_back(std::move(variant));
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.has_clock) return "no time was recorded";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
