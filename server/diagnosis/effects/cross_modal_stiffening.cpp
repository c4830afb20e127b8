// SPDX-License-Identifier: GPL-3.0-or-later
// One mode of deformation stiffens another: c/2 eps_1^2 eps_2^2 of two strains at once.
#include <cmath>

#include "server/diagnosis/effects/effects.h"
#include "server/mechanics/strain_measure.h"

namespace tenter::diagnosis {

namespace {

struct Modes {
  const char* words;
  const char* measure;
};

/// Pairs of modes in the model's own family of measures; shear has one.
std::vector<Modes> pairs_of(const model::Model& model) {
  const char* stretches = measure_family(model) == "soft" ? "soft_pair" : "green_pair";
  return {{"weft and warp", stretches},
          {"weft and shear", "green_u_shear"},
          {"warp and shear", "green_v_shear"}};
}

/// Largest strain that both modes reach in one frame.
double reach_together(const char* name, const Excitation& excitation) {
  model::StrainMeasure description;
  description.name = name;
  if (excitation.sheet) {
    const auto found = excitation.sheet->together.find(measure_key(description));
    return found == excitation.sheet->together.end() ? 0.0 : found->second;
  }
  const auto measure = mechanics::StrainMeasure::make(description);
  mechanics::StrainValue value;
  double reach = 0.0;
  for (const estimation::Curves& curves : excitation.curves) {
    const mechanics::HomogeneousStrain kinematics(curves.path.axis_angle_rad);
    for (const Eigen::Vector3d& q : curves.path.q) {
      measure->evaluate(kinematics.c(q), value);
      reach = std::max(reach, std::min(std::abs(value.value[0]), std::abs(value.value[1])));
    }
  }
  return reach;
}

constexpr double kLeastReach = 1e-3;

}  // namespace

Effect cross_modal_stiffening() {
  Effect effect = described("cross_modal_stiffening");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    Variant all;
    for (const Modes& modes : pairs_of(model)) {
      if (reach_together(modes.measure, excitation) < kLeastReach) continue;
      bool known = false;
      for (const model::Term& term : model.terms)
        known = known || (term.law.name == "cross_modal" && term.strain.name == modes.measure);
      if (known) continue;
      Variant variant;
      variant.words = modes.words;
      model::Term term = new_term(model, std::string("cross_modal_") + modes.measure, modes.measure,
                                  0.0, "cross_modal");
      set_parameter(term.law, "c", 0.0);
      all.words += (all.words.empty() ? "" : ", ") + variant.words;
      all.append.push_back(term);
      variant.append.push_back(std::move(term));
      variants.push_back(std::move(variant));
    }
    if (all.append.size() > 1) variants.push_back(std::move(all));
    return variants;
  };
  effect.not_excited = [](const model::Model& model,
                          const Excitation& e) -> std::optional<std::string> {
    for (const Modes& modes : pairs_of(model))
      if (reach_together(modes.measure, e) >= kLeastReach) return std::nullopt;
    return "no frame strains two modes at once";
  };
  return effect;
}

}  // namespace tenter::diagnosis
