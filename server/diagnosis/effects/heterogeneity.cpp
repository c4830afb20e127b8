// SPDX-License-Identifier: GPL-3.0-or-later
// Stiffness that differs over the material: an own one at each of 3 x 3 samples (thesis 4.4).
//
// The samples' weights sum to one everywhere, so that the model's own stiffness and that of nine
// samples say the same twice. One that is constant moves into the samples, which then have all of
// it; a curve stays, and samples only add to it.
#include "server/diagnosis/effects/effects.h"
#include "server/estimation/heterogeneity/material_samples.h"

namespace tenter::diagnosis {
namespace {

constexpr int kSamples = 3;  // a side

/// The model's own term whose constant stiffness is this place's; none.
const model::Term* constant_stiffness(const model::Model& model, const Place& place) {
  for (const model::Term& term : model.terms)
    if (term.law.name == "linear" && term.strain.name == place.measure &&
        term.support.name == "everywhere" && term.effect.empty() &&
        !term.law.parameters.front().fixed)
      return &term;
  return nullptr;
}

model::Field samples_over(const Eigen::Vector2d& lo_m, const Eigen::Vector2d& hi_m) {
  const Eigen::Vector2d size = hi_m - lo_m;
  model::Field field = estimation::even_samples(kSamples, kSamples, size.x(), size.y()).field;
  field.id = "patches";
  for (std::size_t k = 0; k < field.positions_m.size(); ++k)
    field.positions_m[k] += lo_m[static_cast<Eigen::Index>(k % 2)];
  return field;
}

}  // namespace

Effect heterogeneity() {
  Effect effect = described("heterogeneity");
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    for (const model::Field& field : model.fields)
      if (field.id == "patches") return variants;
    const model::Field field = samples_over(excitation.sheet->lo_m, excitation.sheet->hi_m);
    for (const Place& place : places(model, excitation, false)) {
      if (place.name != "weft" && place.name != "warp" && place.name != "shear") continue;
      Variant variant;
      variant.words = place.name + " over the material";
      variant.parts_are_one = true;  // not every place is stretched
      variant.fields.push_back(field);
      const model::Term* own = constant_stiffness(model, place);
      if (own != nullptr) {
        model::Law moved = own->law;
        set_parameter(moved, "k", 0.0, true);
        variant.replace.emplace_back(own->id, std::move(moved));
      }
      for (int k = 1; k <= field.sample_count(); ++k) {
        model::Term term = new_term(model, "patch_" + place.name + "_" + std::to_string(k),
                                    place.measure, place.angle_rad, "linear");
        set_parameter(term.law, "k", own != nullptr ? own->law.parameters.front().value : 0.0);
        term.support = {"rbf", field.id, k};
        variant.append.push_back(std::move(term));
      }
      variants.push_back(std::move(variant));
    }
    return variants;
  };
  effect.variants = [](const model::Model&, const Excitation&) { return std::vector<Variant>(); };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (!e.sheet) return "no sheet was seen";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
