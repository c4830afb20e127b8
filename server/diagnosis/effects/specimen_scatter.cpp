// SPDX-License-Identifier: GPL-3.0-or-later
// Specimens of one cloth that differ: each resists by a factor of its own, in all its channels.
#include <map>
#include <set>

#include "server/diagnosis/effects/effects.h"

namespace tenter::diagnosis {

namespace {

/// Captures of specimens that another did the same protocol before, with the specimen's name.
/// Captures of different protocols may be of different specimens too; what they differ by is then
/// the protocol's as well.
std::map<std::string, std::vector<std::string>> captures_of_others(const Excitation& excitation) {
  std::map<std::string, std::string> first;  // specimen of each protocol
  std::map<std::string, std::vector<std::string>> others;
  for (const estimation::Curves& curves : excitation.curves) {
    const auto place = first.emplace(curves.protocol, curves.specimen).first;
    if (place->second != curves.specimen) others[curves.specimen].push_back(curves.id);
  }
  return others;
}

}  // namespace

Effect specimen_scatter() {
  Effect effect = described("specimen_scatter");
  effect.variants = [](const model::Model& model, const Excitation& excitation) {
    Variant variant;
    for (const auto& [specimen, captures] : captures_of_others(excitation))
      for (std::size_t k = 0; k < captures.size(); ++k) {
        model::SensorCorrection factor = new_correction(model, "gain", "");
        factor.id += "_" + std::to_string(variant.corrections.size() + 1);
        factor.capture = captures[k];
        variant.corrections.push_back(std::move(factor));
      }
    for (const model::SensorCorrection& known : model.corrections)
      if (known.effect == "specimen_scatter") return std::vector<Variant>();
    variant.parts_are_one = true;  // some specimen is like the first
    variant.words = std::to_string(variant.corrections.size() + 1) + " captures";
    return std::vector<Variant>{std::move(variant)};
  };
  effect.not_excited = [](const model::Model&, const Excitation& e) -> std::optional<std::string> {
    if (captures_of_others(e).empty()) return "no protocol was done with two specimens";
    return std::nullopt;
  };
  effect.sheet_variants = [](const model::Model&, const Excitation&) {
    return std::vector<Variant>();
  };
  effect.sheet_not_excited = [](const model::Model&,
                                const Excitation&) -> std::optional<std::string> {
    return "sheets are not compared specimen by specimen";
  };
  return effect;
}

}  // namespace tenter::diagnosis
