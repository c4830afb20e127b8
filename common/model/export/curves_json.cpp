// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "common/base/json_node.h"
#include "common/model/catalogue.h"
#include "common/model/document.h"
#include "common/model/export/curves.h"

namespace tenter::model {
namespace {

using Json = nlohmann::ordered_json;

Json list_or_null(const std::vector<double>& values) {
  return values.empty() ? Json(nullptr) : Json(values);
}

Json band_json(const Band& band, const std::string& unit) {
  return {{"unit", unit},
          {"values", band.value},
          {"lo", list_or_null(band.lo)},
          {"hi", list_or_null(band.hi)}};
}

Json curve_json(const CurveTable& table) {
  return {{"strain", {{"unit", table.strain_unit}, {"values", table.strain}}},
          {"stress", band_json(table.stress, table.stress_unit)},
          {"stiffness", band_json(table.stiffness, table.stiffness_unit)}};
}

Json parameters_json(const Law& law) {
  Json list = Json::array();
  for (const Parameter& p : law.parameters)
    list.push_back(
        {{"name", p.name},
         {"value", p.value},
         {"unit", p.unit},
         {"fixed", p.fixed},
         {"interval", p.interval_lo && p.interval_hi ? Json({*p.interval_lo, *p.interval_hi})
                                                     : Json(nullptr)}});
  return list;
}

Json term_json(const Model& model, const Term& term, const CurveSet& set) {
  Json json = {{"id", term.id},
               {"strain_measure", term.strain.name},
               {"strain_meaning", find_strain(term.strain.name)->words},
               {"law", term.law.name},
               {"law_meaning", find_law(term.law.name)->words},
               {"acts", term.support.name},
               {"parameters", parameters_json(term.law)},
               {"valid_over_strain", nullptr},
               {"curve", nullptr}};
  for (const StrainRange& range : model.strain_ranges)
    if (range.term == term.id) json["valid_over_strain"] = {range.lo, range.hi};
  for (const CurveTable& table : set.curves)
    if (table.term == term.id) json["curve"] = curve_json(table);
  return json;
}

}  // namespace

Exported write_curves_json(const Model& model, int samples) {
  const CurveSet set = curves_of(model, samples);
  Json terms = Json::array();
  for (const Term& term : model.terms) terms.push_back(term_json(model, term, set));
  const Json document = {{"schema", "tenter.curves"},
                         {"version", 1},
                         {"name", model.name},
                         {"description", model.description},
                         {"interval", "95 %, of one parameter at a time"},
                         {"band", "every parameter anywhere in its interval"},
                         {"terms", std::move(terms)},
                         {"model", Json::parse(write_model(model))}};
  return {document.dump(2) + "\n", {}};
}

Expected<Model> read_curves_json(std::string_view text, std::string_view source_name) {
  const auto inner = read_document(text, source_name, 64u << 20, [](const JsonNode& root) {
    root.expect_object();
    if (root["schema"].text() != "tenter.curves")
      root["schema"].refuse("must be \"tenter.curves\"");
    root["version"].whole(1, 1);
    return root["model"].json().dump();
  });
  if (!inner) return tl::unexpected(inner.error());
  return parse_model(*inner, std::string(source_name) + ": model");
}

}  // namespace tenter::model
