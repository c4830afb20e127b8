// SPDX-License-Identifier: GPL-3.0-or-later
// A camera whose scale is off: every stretch that it observes is off by one factor, in its change
// of length or, where the rest length is not its own, in its length.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

namespace {

constexpr double kLargestOfChanges = 2.0, kLargestOfLengths = 1.1;

/// Components whose free stretch was observed, without repetition.
std::vector<int> observed_stretches(const Excitation& excitation) {
  bool seen[2] = {false, false};
  for (const estimation::Curves& curves : excitation.curves)
    for (const auto& channel : curves.channels)
      if (!channel.is_stress && channel.component < 2) seen[channel.component] = true;
  std::vector<int> components;
  for (int i = 0; i < 2; ++i)
    if (seen[i]) components.push_back(i);
  return components;
}

bool has_scale(const model::Model& model) {
  for (const model::SensorCorrection& c : model.corrections)
    if (c.type.starts_with("camera_")) return true;
  return false;
}

/// Where a picture's origin lies is its own: what is scaled about it is shifted, too.
Variant about_another_place(const model::Model& model, Variant variant) {
  model::SensorCorrection shift =
      new_sheet_correction(model, "camera_pose", "", variant.corrections.front().capture);
  shift.id = "origin_of_" + variant.corrections.front().id;
  for (model::Parameter& p : shift.parameters) p.fixed = p.name.starts_with("turn_");
  variant.words += ", about a place of its own";
  variant.parts_are_one = true;
  variant.corrections.push_back(std::move(shift));
  return variant;
}

}  // namespace

Effect camera_scale() {
  Effect effect = described("camera_scale");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    if (has_scale(model)) return variants;
    const std::vector<int> components = observed_stretches(excitation);
    const auto add = [&](const std::string& type, const std::string& component) {
      Variant variant;
      variant.words = std::string(type == "camera_scale" ? "changes of length" : "lengths") +
                      (component.empty() ? ", both stretches" : ", stretch " + component);
      model::SensorCorrection correction = new_correction(model, type, component);
      // beyond, a camera is noticed by eye, and what looks like one is a contraction
      const double largest = type == "camera_scale" ? kLargestOfChanges : kLargestOfLengths;
      correction.parameters.front().lower = 1.0 / largest;
      correction.parameters.front().upper = largest;
      variant.corrections.push_back(std::move(correction));
      variants.push_back(std::move(variant));
    };
    for (const char* type : {"camera_scale", "camera_length"}) {
      for (const int component : components) add(type, estimation::component_name(component));
      if (components.size() > 1) add(type, "");
    }
    return variants;
  };
  effect.is_exact = true;
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    auto variants = sheet_capture_variants(model, excitation, "camera_scale");
    for (Variant& variant : variants) {
      variant.corrections.front().parameters.front().lower = 1.0 / kLargestOfLengths;
      variant.corrections.front().parameters.front().upper = kLargestOfLengths;
    }
    const std::size_t about_the_middle = variants.size();
    for (std::size_t k = 0; k < about_the_middle; ++k)
      variants.push_back(about_another_place(model, variants[k]));
    return variants;
  };
  effect.sheet_not_excited = [](const model::Model&,
                                const Excitation&) -> std::optional<std::string> {
    return std::nullopt;
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (observed_stretches(e).empty()) return "no free stretch was observed";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
