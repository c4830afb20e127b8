// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "common/model/catalogue.h"
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

void bound_parameter(model::Law& law, const std::string& name, double lower, double upper) {
  for (model::Parameter& p : law.parameters) {
    if (p.name != name) continue;
    p.lower = lower;
    p.upper = upper;
    p.value = std::clamp(p.value, lower, upper);
  }
}

bool same_measure(const model::StrainMeasure& measure, const Place& place) {
  const std::string& name = measure.name;
  const auto ends = [&](const char* suffix) { return name.ends_with(suffix); };
  const model::StrainRow* row = model::find_strain(name);
  if (place.name.starts_with("bend_")) return name == place.measure;
  if ((row != nullptr && row->domain == model::Domain::hinge) || name.starts_with("ring2_"))
    return false;
  if (place.name == "weft") return ends("_u");
  if (place.name == "warp") return ends("_v") && !ends("_uv");
  if (place.name == "shear") return ends("_uv");
  return ends("fibre_pair") && std::abs(measure.angle_rad - place.angle_rad) < 1e-6;
}

std::vector<Variant> channel_variants(const model::Model& model, const Excitation& excitation,
                                      const std::string& type) {
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
}

std::vector<Variant> memory_variants(const model::Model& model, const Excitation& excitation,
                                     const std::string& id, const std::string& law,
                                     const std::string& amplitude, const std::string& scale,
                                     const std::vector<double>& shares, double longest) {
  std::vector<Variant> variants;
  std::vector<Place> along;
  for (const Place& place : places(model, excitation, false))
    if ((place.name == "weft" || place.name == "warp") && place.hi > 1e-4) along.push_back(place);
  for (const auto& group : place_groups(along)) {
    Variant variant;
    variant.words = place_words(group);
    model::Model taken = model;
    for (const Place& place : group) {
      model::Term term =
          new_term(taken, id + "_" + place.name, place.measure, place.angle_rad, law);
      set_parameter(term.law, amplitude, 0.0);
      bound_parameter(term.law, scale, 1e-3 * place.hi, longest * place.hi);
      taken.terms.push_back(term);
      variant.append.push_back(std::move(term));
    }
    for (const double share : shares) {
      Setting setting;
      for (std::size_t i = 0; i < group.size(); ++i)
        setting.emplace_back(variant.append[i].id + "." + scale, share * group[i].hi);
      variant.grid.push_back(std::move(setting));
    }
    variants.push_back(std::move(variant));
  }
  return variants;
}

}  // namespace tenter::diagnosis
