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
//
// A yarn that runs across, or a cloth that lies askew in its clips, ties stretch and shear
// together, which no sum of these does. Only sheets are free to show it: there fibres at a few
// angles to either side are asked, too.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {
namespace {

constexpr double kDegree = 0.017453292519943295;

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

/// "weft", "30 degrees from the weft".
std::string words_of(const Place& place) {
  if (!place.measure.ends_with("fibre")) return place.name;
  return std::to_string(std::lround(place.angle_rad / kDegree)) + " degrees from the weft";
}

Variant own_stiffness(const model::Model& model, const std::vector<Place>& along) {
  Variant variant;
  variant.words = "an own stiffness along ";
  for (const Place& place : along) {
    if (!variant.append.empty()) variant.words += " and ";
    variant.words += words_of(place);
    model::Term term =
        new_term(model, "own_" + place.name, place.measure, place.angle_rad, "linear");
    set_parameter(term.law, "k", 0.0);
    variant.append.push_back(std::move(term));
  }
  return variant;
}

/// Fibres at an angle from the weft, of which the model has none yet.
std::vector<Place> askew_places(const model::Model& model) {
  std::vector<Place> askew;
  const std::string measure = measure_family(model) == "green" ? "green_fibre" : "fibre";
  for (const int degrees : {30, -30, 45, -45, 60, -60}) {
    const double angle_rad = degrees * kDegree;
    const bool is_there = std::ranges::any_of(model.terms, [&](const model::Term& term) {
      return term.strain.name == measure && std::abs(term.strain.angle_rad - angle_rad) < 1e-6;
    });
    const std::string side = degrees < 0 ? "minus_" : "";
    if (!is_there)
      askew.push_back({side + std::to_string(std::abs(degrees)) + "_degrees", measure, angle_rad});
  }
  return askew;
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
    if (excitation.sheet)
      for (const Place& place : askew_places(model))
        variants.push_back(own_stiffness(model, {place}));
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
