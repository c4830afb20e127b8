// SPDX-License-Identifier: GPL-3.0-or-later
// A load cell at the end of its range: what is above a cap is lost, in part or whole.
#include <algorithm>
#include <cmath>

#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

namespace {

/// Largest reading of a component (N/m).
double largest_reading(const Excitation& excitation, const std::string& component) {
  double largest = 0.0;
  for (const estimation::Curves& curves : excitation.curves)
    for (const auto& channel : curves.channels) {
      if (!channel.is_stress || estimation::component_name(channel.component) != component)
        continue;
      for (const double reading : channel.measured)
        if (std::isfinite(reading)) largest = std::max(largest, reading);
    }
  return largest;
}

/// Bounds and grid of each variant's cap by the largest reading of its channel.
template <class Largest>
std::vector<Variant> with_caps(std::vector<Variant> variants, const Largest& largest_of) {
  for (Variant& variant : variants) {
    model::SensorCorrection& cell = variant.corrections.front();
    const double largest = largest_of(cell.component);
    // a cap that nothing reaches, or that cuts more than half, is no end of a range
    cell.parameters[1].lower = 0.4 * largest;
    cell.parameters[1].upper = 1.2 * largest;
    cell.parameters[1].value = largest;
    for (const double share : {0.5, 0.65, 0.8, 0.9, 0.96, 1.0})
      variant.grid.push_back({{cell.id + ".cap", share * largest}});
  }
  std::erase_if(variants, [](const Variant& v) {
    return !(v.corrections.front().parameters[1].value > 0.0);
  });
  return variants;
}

}  // namespace

Effect load_cell_saturation() {
  Effect effect = described("load_cell_saturation");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    return with_caps(
        channel_variants(model, excitation, "saturation"),
        [&](const std::string& component) { return largest_reading(excitation, component); });
  };
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    return with_caps(sheet_channel_variants(model, excitation, "saturation"),
                     [&](const std::string& name) {
                       double largest = 0.0;
                       for (const SheetExcitation::Force& force : excitation.sheet->forces)
                         if (force.name == name) largest = std::max(largest, force.largest_N);
                       return largest;
                     });
  };
  effect.sheet_not_excited = [](const model::Model&,
                                const Excitation& e) -> std::optional<std::string> {
    for (const SheetExcitation::Force& force : e.sheet->forces)
      if (force.largest_N > 0.0) return std::nullopt;
    return "no channel of force was pulled";
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    for (const int component : e.stress_components)
      if (largest_reading(e, estimation::component_name(component)) > 0.0) return std::nullopt;
    return "no channel of force was pulled";
  };
  return effect;
}

}  // namespace tenter::diagnosis
