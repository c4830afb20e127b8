// SPDX-License-Identifier: GPL-3.0-or-later
// Anisotropy: weft, warp and 45 degrees differ.
//
// What is added is stiffness, and none of it may be negative. A direction that is softer than the
// others is then one in which the shared stiffness fell and the others have more of their own: of
// an isotropic sheet (k_u = k_v = lambda + 2 mu, k_uv = mu, coupling lambda) with
//
//   k_u = lambda + 2 mu + x_u     k_v = lambda + 2 mu + x_v     k_uv = mu + x_uv
//
// every orthotropic one has the same lambda, the mu that is the least of (k_u - lambda)/2,
// (k_v - lambda)/2 and k_uv, and two at most of x_u, x_v, x_uv. So directions come alone and in
// twos.
#include <algorithm>
#include <utility>

#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {
namespace {

/// Directions that have no stiffness of their own yet.
std::vector<Place> shared_places(const model::Model& model, const Excitation& excitation) {
  std::vector<Place> shared;
  for (const Place& place : places(model, excitation, false)) {
    // what only adds memory along a direction gives it no stiffness of its own
    const bool has_stiffness =
        std::any_of(model.terms.begin(), model.terms.end(), [&](const model::Term& term) {
          return same_measure(term.strain, place) &&
                 (term.law.name == "linear" || term.law.name == "convex_spline");
        });
    if (!has_stiffness && (place.name != "diagonal" || has_coupling(model)))
      shared.push_back(place);
  }
  return shared;
}

Variant own_stiffness(const model::Model& model, const std::vector<Place>& along) {
  Variant variant;
  variant.words = "an own stiffness along ";
  for (const Place& place : along) {
    if (!variant.append.empty()) variant.words += " and ";
    variant.words += place.name;
    model::Term term =
        new_term(model, "own_" + place.name, place.measure, place.angle_rad, "linear");
    set_parameter(term.law, "k", 0.0);
    variant.append.push_back(std::move(term));
  }
  return variant;
}

bool is_in_plane(const Place& place) {
  return place.name == "weft" || place.name == "warp" || place.name == "shear";
}

}  // namespace

Effect anisotropy() {
  Effect effect = described("anisotropy");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    const std::vector<Place> shared = shared_places(model, excitation);
    std::vector<Variant> variants;
    variants.reserve(shared.size() * (shared.size() + 1) / 2);
    for (const Place& place : shared) variants.push_back(own_stiffness(model, {place}));
    for (std::size_t i = 0; i < shared.size(); ++i)
      for (std::size_t k = i + 1; k < shared.size(); ++k)
        if (is_in_plane(shared[i]) && is_in_plane(shared[k]))
          variants.push_back(own_stiffness(model, {shared[i], shared[k]}));
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
