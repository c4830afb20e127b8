// SPDX-License-Identifier: GPL-3.0-or-later
// Cameras that were moved: points are turned and shifted, all of a capture alike.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect camera_pose() {
  Effect effect = described("camera_pose");
  effect.is_exact = true;
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    return sheet_capture_variants(model, excitation, "camera_pose");
  };
  effect.variants = [](const model::Model&, const Excitation&) { return std::vector<Variant>(); };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.sheet) return "no sheet was seen";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
