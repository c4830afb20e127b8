// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "common/model/catalogue.h"
#include "common/model/document.h"

namespace tenter::model {

namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json write_parameters(const std::vector<Parameter>& parameters) {
  Json object = Json::object();
  for (const Parameter& parameter : parameters) {
    Json entry = {{"value", parameter.value},
                  {"unit", parameter.unit},
                  {"min", number_or_null(parameter.lower)},
                  {"max", number_or_null(parameter.upper)},
                  {"fixed", parameter.fixed}};
    if (parameter.std_error) entry["std_error"] = *parameter.std_error;
    if (parameter.interval_lo && parameter.interval_hi)
      entry["interval"] = {*parameter.interval_lo, *parameter.interval_hi};
    object[parameter.name] = std::move(entry);
  }
  return object;
}

Json write_term(const Term& term) {
  const StrainRow* strain_row = find_strain(term.strain.name);
  const LawRow* law_row = find_law(term.law.name);

  Json strain = {{"name", term.strain.name}};
  if (strain_row != nullptr && strain_row->has_angle) strain["angle_rad"] = term.strain.angle_rad;
  if (strain_row != nullptr && strain_row->has_angle && strain_row->domain == Domain::solid)
    strain["elevation_rad"] = term.strain.elevation_rad;

  Json law = {{"name", term.law.name}};
  if (law_row != nullptr && law_row->spline) law["range"] = {term.law.range_lo, term.law.range_hi};
  if (!term.law.knots.empty()) law["knots"] = term.law.knots;
  law["parameters"] = write_parameters(term.law.parameters);

  Json object = {{"id", term.id}};
  if (!term.effect.empty()) object["effect"] = term.effect;
  object["strain"] = std::move(strain);
  object["law"] = std::move(law);
  object["support"] = {{"name", term.support.name}};
  if (!term.support.field.empty()) {
    object["support"]["field"] = term.support.field;
    object["support"]["sample"] = term.support.sample;
  }
  return object;
}

Json write_field(const Field& field) {
  Json positions = Json::array();
  for (int k = 0; k < field.sample_count(); ++k) {
    const auto first = field.positions_m.begin() + k * field.dimensions;
    positions.push_back(std::vector<double>(first, first + field.dimensions));
  }
  return {{"id", field.id}, {"positions_m", std::move(positions)}, {"width_m", field.width_m}};
}

Json write_limit(const EnergyLimit& limit) {
  return {{"id", limit.id},
          {"terms", limit.terms.empty() ? Json("all") : Json(limit.terms)},
          {"energy_max", {{"value", limit.energy_max}, {"unit", limit.unit}}}};
}

Json write_correction(const SensorCorrection& correction) {
  Json object = {{"id", correction.id}};
  if (!correction.effect.empty()) object["effect"] = correction.effect;
  object["type"] = correction.type;
  if (!correction.capture.empty()) object["capture"] = correction.capture;
  if (!correction.component.empty()) object["component"] = correction.component;
  object["parameters"] = write_parameters(correction.parameters);
  return object;
}

}  // namespace

std::string write_model(const Model& model) {
  Json root = {{"schema", "tenter.model"},
               {"version", 1},
               {"name", model.name},
               {"description", model.description}};
  root["terms"] = Json::array();
  for (const Term& term : model.terms) root["terms"].push_back(write_term(term));
  if (!model.fields.empty()) {
    root["fields"] = Json::array();
    for (const Field& field : model.fields) root["fields"].push_back(write_field(field));
  }
  if (!model.limits.empty()) {
    root["limits"] = Json::array();
    for (const EnergyLimit& limit : model.limits) root["limits"].push_back(write_limit(limit));
  }
  if (!model.corrections.empty()) {
    root["corrections"] = Json::array();
    for (const SensorCorrection& correction : model.corrections)
      root["corrections"].push_back(write_correction(correction));
  }
  if (!model.strain_ranges.empty()) {
    root["strain_ranges"] = Json::array();
    for (const StrainRange& range : model.strain_ranges)
      root["strain_ranges"].push_back({{"term", range.term}, {"lo", range.lo}, {"hi", range.hi}});
  }
  if (model.lineage)
    root["lineage"] = {{"parent", model.lineage->parent},
                       {"added", model.lineage->added},
                       {"captures", model.lineage->captures}};
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tenter::model
