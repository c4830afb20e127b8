// SPDX-License-Identifier: GPL-3.0-or-later
// Nonlinear stiffness: a tangent that changes with strain, as a convex spline in the place of a
// constant.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {
namespace {

constexpr int kControlPoints =
    4;  // one cubic tangent over the range, non-negative by its Bernstein coefficients

/// A spline that equals the constant stiffness k.
model::Law flat_spline(const Place& place, double stiffness) {
  const model::Model empty;
  model::Law law =
      new_term(empty, "spline", place.measure, 0.0, "convex_spline", kControlPoints).law;
  law.range_lo = place.lo;
  law.range_hi = place.hi;
  for (model::Parameter& p : law.parameters) p.value = stiffness;
  return law;
}

}  // namespace

Effect nonlinear_stiffness() {
  Effect effect = described("nonlinear_stiffness");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    std::vector<Place> candidates = places(model, excitation, true);
    // fibres at 45 degrees tie the two stretches together: without a coupling in the model they
    // would be one in disguise
    if (!has_coupling(model))
      std::erase_if(candidates, [](const Place& place) { return place.name == "diagonal"; });
    for (const auto& group : place_groups(candidates)) {
      Variant variant;
      variant.words = place_words(group);
      model::Model taken = model;
      for (const Place& place : group) {
        const model::Term* linear = nullptr;
        bool has_spline = false;
        for (const model::Term& term : model.terms) {
          const bool here = same_measure(term.strain, place);
          if (here && term.law.name == "linear") linear = &term;
          if (here && term.law.name == "convex_spline") has_spline = true;
        }
        if (has_spline) continue;
        if (linear) {
          variant.replace.emplace_back(linear->id,
                                       flat_spline(place, linear->law.parameters[0].value));
        } else {
          model::Term term = new_term(taken, "stiffening_" + place.name, place.measure,
                                      place.angle_rad, "convex_spline", kControlPoints);
          term.law = flat_spline(place, 0.0);
          taken.terms.push_back(term);
          variant.append.push_back(std::move(term));
        }
      }
      if (variant.replace.size() + variant.append.size() == group.size())
        variants.push_back(std::move(variant));
    }
    return variants;
  };
  effect.not_excited = [](const model::Model&, const Excitation&) -> std::optional<std::string> {
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
