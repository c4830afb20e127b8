// SPDX-License-Identifier: GPL-3.0-or-later
// A clip that slipped: the force steps once, in one run, and does not come back.
#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {
namespace {

std::pair<std::string, double> place(const model::SensorCorrection& correction,
                                     const estimation::Curves& curves, int frame) {
  return {correction.id + ".at_frame",
          static_cast<double>(curves.origin[static_cast<std::size_t>(frame)])};
}

}  // namespace

Effect clip_slip() {
  Effect effect = described("clip_slip");
  effect.in_every_run = false;
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    // a step may begin at any of a dozen places of a run, and then at any frame of the likeliest
    // run
    constexpr int kPlaces = 12;
    for (const estimation::Curves& curves : excitation.curves) {
      if (curves.runs.size() < 2 && excitation.curves.size() < 2) continue;
      for (const auto& channel : curves.channels) {
        if (!channel.is_stress) continue;
        for (const estimation::CurveRun& run : curves.runs) {
          Variant variant;
          const std::string name = estimation::component_name(channel.component);
          variant.words = "run " + std::to_string(run.number) + ", stress " + name;
          model::SensorCorrection correction = new_correction(model, "clip_slip", name);
          correction.capture = curves.id;
          for (int k = 1; k < kPlaces; ++k) {
            const int at = run.first + (run.last - run.first) * k / kPlaces;
            if (at - run.first < 3 || run.last - at < 3) continue;
            variant.grid.push_back({place(correction, curves, at)});
          }
          for (int at = run.first + 3; at + 3 <= run.last; ++at)
            variant.finer.push_back({place(correction, curves, at)});
          variant.corrections.push_back(std::move(correction));
          if (!variant.grid.empty()) variants.push_back(std::move(variant));
        }
      }
    }
    int searched = 0;
    for (const Variant& v : variants) searched += static_cast<int>(v.finer.size());
    for (Variant& v : variants) v.searched = searched;
    return variants;
  };
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    constexpr int kPlaces = 6;
    for (const SheetExcitation::Force& force : excitation.sheet->forces) {
      if (force.name.empty() || force.frames < 8) continue;
      Variant variant;
      variant.words = "clip of force " + force.name + " in " + force.capture;
      model::SensorCorrection slip =
          new_sheet_correction(model, "clip_slip", force.name, force.capture);
      for (int k = 1; k < kPlaces; ++k) {
        const int at_frame = force.frames * k / kPlaces;
        variant.grid.push_back({{slip.id + ".at_frame", static_cast<double>(at_frame)}});
      }
      for (int at = 3; at + 3 < force.frames; ++at)
        variant.finer.push_back({{slip.id + ".at_frame", static_cast<double>(at)}});
      variant.corrections.push_back(std::move(slip));
      variants.push_back(std::move(variant));
    }
    int searched = 0;
    for (const Variant& v : variants) searched += static_cast<int>(v.finer.size());
    for (Variant& v : variants) v.searched = searched;
    return variants;
  };
  effect.sheet_not_excited = [](const model::Model&,
                                const Excitation& e) -> std::optional<std::string> {
    for (const SheetExcitation::Force& force : e.sheet->forces)
      if (!force.name.empty()) return std::nullopt;
    return "no clip's force has a name to blame";
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    std::size_t runs = 0;
    for (const auto& c : e.curves) runs += c.runs.size();
    if (runs < 2) return "one run only: nothing to compare it with";
    return std::nullopt;
  };
  return effect;
}

}  // namespace tenter::diagnosis
