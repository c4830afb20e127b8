// SPDX-License-Identifier: GPL-3.0-or-later
// Plastic set: the rest length moves with each new maximum and nothing else moves it.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect plastic_set() {
  Effect effect;
  effect.id = "plastic_set";
  effect.words = "plastic set: each new maximum leaves the specimen longer, and small cycles do not undo it";
  effect.mistaken_for = {"internal_friction", "first_cycle_softening"};
  effect.split_by = {"nested_loops_with_return",
                     "Loops to growing maxima with a return to zero and a few small cycles after each: friction's "
                     "offset is undone by the small cycles, a set is not.",
                     {{"cycle", "to a quarter of the range and back to zero force, three times"},
                      {"cycle", "to a half, the same"},
                      {"cycle", "to the full range, the same"}}};
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    return memory_variants(model, excitation, "set", "plastic_set", "c", "yield_strain", {0.001, 0.3, 0.6}, 1.5);
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.has_unloading && !e.has_repeated_loading) return "no strain is reached twice";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
