// SPDX-License-Identifier: GPL-3.0-or-later
// Anisotropy: weft, warp and 45 degrees differ.
#include <algorithm>

#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

Effect anisotropy() {
  Effect effect = described("anisotropy");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    for (const Place& place : places(model, excitation, false)) {
      // what only adds memory along a direction gives it no stiffness of its own
      const bool has_stiffness =
          std::any_of(model.terms.begin(), model.terms.end(), [&](const model::Term& term) {
            return same_measure(term.strain, place) &&
                   (term.law.name == "linear" || term.law.name == "convex_spline");
          });
      if (has_stiffness || (place.name == "diagonal" && !has_coupling(model))) continue;
      Variant variant;
      variant.words = "an own stiffness along " + place.name;
      model::Term term =
          new_term(model, "own_" + place.name, place.measure, place.angle_rad, "linear");
      set_parameter(term.law, "k", 0.0);
      variant.append.push_back(std::move(term));
      variants.push_back(std::move(variant));
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (e.sheet) return std::nullopt;  // a sheet is seen in all of them
    int directions = 0;
    for (const auto& c : e.curves) directions += c.path.axis_angle_rad != 0.0 ? 1 : 0;
    if (e.stress_components.size() + static_cast<std::size_t>(directions) < 2)
      return "the force was measured in one direction only";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
