// SPDX-License-Identifier: GPL-3.0-or-later
// Load cells: offset, gain and drift of one channel of force.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {
namespace {

Effect load_cell(const std::string& id, const std::string& words, const std::string& type,
                 const NextProtocol& split_by) {
  Effect effect;
  effect.id = id;
  effect.words = words;
  effect.kind = Effect::Kind::sensor;
  effect.split_by = split_by;
  effect.variants = [type](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    for (const int component : excitation.stress_components) {
      const std::string name = estimation::component_name(component);
      bool known = false;
      for (const model::SensorCorrection& c : model.corrections)
        known = known || (c.type == type && c.component == name);
      if (known) continue;
      Variant variant;
      variant.words = "channel of stress " + name;
      variant.corrections.push_back(new_correction(model, type, name));
      variants.push_back(std::move(variant));
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation&) -> std::optional<std::string> {
    return std::nullopt;
  };
  return effect;
}

const NextProtocol kDeadWeights = {"dead_weights",
                                   "Unmount the specimen, read zero, hang two known weights on the "
                                   "clip, read zero again after ten minutes.",
                                   {{"blank", "no specimen, 60 s"},
                                    {"weight", "two known weights in turn"},
                                    {"blank", "no specimen, 600 s later"}}};

}  // namespace

Effect load_cell_offset() {
  Effect effect =
      load_cell("load_cell_offset", "a constant error of the load cell", "offset", kDeadWeights);
  effect.mistaken_for = {"load_cell_drift", "plastic_set"};
  return effect;
}

Effect load_cell_gain() {
  Effect effect = load_cell("load_cell_gain", "a load cell that shows a multiple of the force",
                            "gain", kDeadWeights);
  effect.mistaken_for = {"anisotropy"};
  return effect;
}

Effect load_cell_drift() {
  Effect effect = load_cell("load_cell_drift", "a zero of the load cell that moves with the clock",
                            "drift", kDeadWeights);
  effect.mistaken_for = {"load_cell_offset", "viscosity", "plastic_set"};
  effect.needs_rate = true;
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.has_clock) return "no time was recorded";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
