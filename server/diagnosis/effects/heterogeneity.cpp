// SPDX-License-Identifier: GPL-3.0-or-later
// Stiffness that differs over the material: an own one at each of 3 x 3 samples (thesis 4.4), and
// where that was found at each of 5 x 5: seams and patches are narrower than a third of a sheet.
//
// The samples' weights sum to one everywhere, so that the model's own stiffness and that of nine
// samples say the same twice. One that is constant moves into the samples, which then have all of
// it; a curve stays, and samples only add to it. So do the few when the many take their place.
#include "server/diagnosis/effects/effects.h"
#include "server/estimation/heterogeneity/material_samples.h"
#include "server/mechanics/support.h"

namespace tenter::diagnosis {
namespace {

constexpr int kFew = 3, kMany = 5;  // a side
constexpr const char *kFewId = "patch", *kManyId = "fine_patch";

/// The model's own term whose constant stiffness is this place's; none.
const model::Term* constant_stiffness(const model::Model& model, const Place& place) {
  for (const model::Term& term : model.terms)
    if (term.law.name == "linear" && term.strain.name == place.measure &&
        term.support.name == "everywhere" && term.effect.empty() &&
        !term.law.parameters.front().fixed)
      return &term;
  return nullptr;
}

model::Field samples_over(const SheetExcitation& sheet, int a_side, const char* id) {
  const Eigen::Vector2d& lo_m = sheet.lo_m;
  const Eigen::Vector2d size = sheet.hi_m - lo_m;
  model::Field field = estimation::even_samples(a_side, a_side, size.x(), size.y()).field;
  field.id = id;
  for (std::size_t k = 0; k < field.positions_m.size(); ++k)
    field.positions_m[k] += lo_m[static_cast<Eigen::Index>(k % 2)];
  return field;
}

/// What a field of samples says of a place in the material, the mean of its own and its
/// neighbours' stiffnesses as they weigh there.
double stiffness_at(const model::Model& model, const std::vector<const model::Term*>& samples,
                    const Eigen::Vector2d& place_m) {
  double sum = 0.0;
  for (const model::Term* term : samples)
    if (const auto support = mechanics::Support::make(model, term->support))
      sum += support->weight(place_m.data()) * term->law.parameters.front().value;
  return sum;
}

/// The terms that stand for this place's samples on a field.
std::vector<const model::Term*> samples_on(const model::Model& model, const Place& place,
                                           const char* field) {
  std::vector<const model::Term*> terms;
  for (const model::Term& term : model.terms)
    if (term.support.field == field && term.strain.name == place.measure) terms.push_back(&term);
  return terms;
}

/// Moves what a term has of stiffness into samples, which take it over.
void move_out(const model::Term& term, Variant& variant) {
  model::Law moved = term.law;
  set_parameter(moved, "k", 0.0, true);
  variant.replace.emplace_back(term.id, std::move(moved));
}

/// Own stiffnesses of each place at each sample.
Variant samples_of(const model::Model& model, const std::vector<Place>& group,
                   const model::Field& field) {
  Variant variant;
  variant.words = place_words(group) + " at " + std::to_string(field.sample_count()) +
                  " places of the material";
  variant.parts_are_one = true;  // not every place is stretched
  variant.fields.push_back(field);
  for (const Place& place : group) {
    const model::Term* own = constant_stiffness(model, place);
    const auto fewer = samples_on(model, place, kFewId);
    if (own != nullptr) move_out(*own, variant);
    for (const model::Term* term : fewer) move_out(*term, variant);
    for (int k = 1; k <= field.sample_count(); ++k) {
      model::Term term = new_term(model, field.id + "_" + place.name + "_" + std::to_string(k),
                                  place.measure, place.angle_rad, "linear");
      const auto at = static_cast<std::size_t>(2 * (k - 1));
      const double start =
          fewer.empty()
              ? (own != nullptr ? own->law.parameters.front().value : 0.0)
              : stiffness_at(model, fewer, {field.positions_m[at], field.positions_m[at + 1]});
      set_parameter(term.law, "k", start);
      term.support = {"rbf", field.id, k};
      variant.append.push_back(std::move(term));
    }
  }
  return variant;
}

}  // namespace

Effect heterogeneity() {
  Effect effect = described("heterogeneity");
  effect.sheet_variants = [](const model::Model& model, const Excitation& excitation) {
    std::vector<Variant> variants;
    const auto has = [&](const char* id) {
      return std::ranges::any_of(model.fields, [&](const auto& field) { return field.id == id; });
    };
    if (has(kManyId)) return variants;
    std::vector<Place> each;
    for (Place& place : places(model, excitation, false))
      if (place.name == "weft" || place.name == "warp" || place.name == "shear")
        each.push_back(std::move(place));
    if (has(kFewId)) {
      std::erase_if(each, [&](const Place& p) { return samples_on(model, p, kFewId).empty(); });
      if (!each.empty())
        variants.push_back(
            samples_of(model, each, samples_over(*excitation.sheet, kMany, kManyId)));
      return variants;
    }
    const model::Field field = samples_over(*excitation.sheet, kFew, kFewId);
    for (const Place& place : each) variants.push_back(samples_of(model, {place}, field));
    // a seam or a patch is stiffer in all directions
    if (each.size() > 1) variants.push_back(samples_of(model, each, field));
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
