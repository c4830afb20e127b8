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

namespace {

bool has_correction(const model::Model& model, const model::SensorCorrection& correction) {
  for (const model::SensorCorrection& c : model.corrections)
    if (c.type == correction.type && c.component == correction.component &&
        c.capture == correction.capture)
      return true;
  return false;
}

}  // namespace

std::vector<Variant> sheet_channel_variants(const model::Model& model, const Excitation& excitation,
                                            const std::string& type) {
  std::vector<Variant> variants;
  const auto& forces = excitation.sheet->forces;
  const auto add = [&](const std::string& name, const std::string& capture) {
    Variant variant;
    variant.words = (name.empty() ? "all channels of force" : "force " + name) +
                    (capture.empty() ? "" : " in " + capture);
    variant.corrections.push_back(new_sheet_correction(model, type, name, capture));
    const bool known = has_correction(model, variant.corrections.front());
    if (!known) variants.push_back(std::move(variant));
  };
  for (std::size_t k = 0; k < forces.size(); ++k) {
    const auto same = [&](const SheetExcitation::Force& f) { return f.name == forces[k].name; };
    const auto first = std::find_if(forces.begin(), forces.end(), same);
    if (first == forces.begin() + static_cast<std::ptrdiff_t>(k)) add(forces[k].name, "");
    // one cell of a rig, or one that was read wrong in one capture
    const bool is_shared = std::any_of(forces.begin(), forces.end(), [&](const auto& f) {
      return same(f) && f.capture != forces[k].capture;
    });
    if (is_shared && !forces[k].name.empty()) add(forces[k].name, forces[k].capture);
  }
  return variants;
}

std::vector<Variant> sheet_capture_variants(const model::Model& model, const Excitation& excitation,
                                            const std::string& type) {
  std::vector<Variant> variants;
  std::vector<std::string> captures = {""};
  if (excitation.sheet->captures.size() > 1)
    captures.insert(captures.end(), excitation.sheet->captures.begin(),
                    excitation.sheet->captures.end());
  for (const std::string& capture : captures) {
    Variant variant;
    variant.words = capture.empty() ? "all captures" : "capture " + capture;
    variant.corrections.push_back(new_sheet_correction(model, type, "", capture));
    if (!has_correction(model, variant.corrections.front())) variants.push_back(std::move(variant));
  }
  return variants;
}

std::vector<Variant> onset_variants(const model::Model& model, const Excitation& excitation,
                                    const Onset& onset) {
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
          new_term(taken, onset.id + "_" + place.name, place.measure, place.angle_rad, onset.law);
      set_parameter(term.law, onset.amplitude, 0.0);
      bound_parameter(term.law, onset.strain, onset.least * place.hi, onset.most * place.hi);
      taken.terms.push_back(term);
      variant.append.push_back(std::move(term));
    }
    for (const double share : onset.shares) {
      Setting setting;
      for (std::size_t i = 0; i < group.size(); ++i)
        setting.emplace_back(variant.append[i].id + "." + onset.strain, share * group[i].hi);
      variant.grid.push_back(std::move(setting));
    }
    variants.push_back(std::move(variant));
  }
  return variants;
}

}  // namespace tenter::diagnosis
