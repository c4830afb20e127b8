// SPDX-License-Identifier: GPL-3.0-or-later
// Strain limit: nothing below a strain, sudden stiffness beyond it (yarns that are straight, a
// backing that takes over).
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect strain_limit() {
  Effect effect = described("strain_limit");
  effect.special_form_of = "nonlinear_stiffness";
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    // a limit near zero would be the stiffness that the model has
    return onset_variants(
        model, excitation,
        {"limit", "strain_limit", "k", "limit", {0.45, 0.6, 0.75, 0.87}, 0.2, 0.97});
  };
  effect.not_excited = [](const model::Model&, const Excitation&) -> std::optional<std::string> {
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
