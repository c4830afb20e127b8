// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "common/base/json_node.h"
#include "common/model/catalogue.h"
#include "common/model/document.h"

namespace tenter::model {

namespace {

using Node = JsonNode;

void read_parameter(const Node& node, Parameter& parameter) {
  if (node.is_number()) {
    parameter.value = node.number();
    return;
  }
  if (!node.is_object()) node.refuse("must be a number, or an object with the key 'value'");
  node.expect_object({"value", "unit", "min", "max", "fixed", "std_error", "interval"});
  parameter.value = node["value"].number();
  parameter.unit = node.text_or("unit", parameter.unit);
  if (node.has("min")) parameter.lower = node["min"].number_or_null();
  if (node.has("max")) parameter.upper = node["max"].number_or_null();
  if (node.has("fixed")) parameter.fixed = node["fixed"].boolean();
  if (node.has("std_error")) parameter.std_error = node["std_error"].number_or_null();
  if (node.has("interval") && !node["interval"].is_null())
    std::tie(parameter.interval_lo, parameter.interval_hi) = node["interval"].pair();
}

/// Lays what the document says over the defaults, whatever the order of its keys.
std::vector<Parameter> read_parameters(const Node& node, std::vector<Parameter> defaults) {
  node.expect_object();
  for (const std::string& key : node.keys()) {
    const auto found = std::find_if(defaults.begin(), defaults.end(),
                                    [&key](const Parameter& p) { return p.name == key; });
    if (found == defaults.end()) {
      std::string known;
      for (const Parameter& p : defaults) known += (known.empty() ? "" : ", ") + p.name;
      node.child(key).refuse("there is no such parameter; the parameters are " + known);
    }
    read_parameter(node.child(key), *found);
  }
  return defaults;
}

Law read_law(const Node& node, Domain domain) {
  node.expect_object({"name", "range", "knots", "parameters"});
  Law law;
  law.name = node["name"].text();
  const LawRow* row = find_law(law.name);
  if (row == nullptr) {
    std::string known;
    for (const LawRow& r : law_catalogue())
      known += (known.empty() ? "" : ", ") + std::string(r.name);
    node["name"].refuse("there is no law '" + law.name + "'; the laws are " + known);
  }
  if (node.has("range")) {
    if (!row->spline) node["range"].refuse("only spline laws have a range");
    std::tie(law.range_lo, law.range_hi) = node["range"].pair();
  }
  if (node.has("knots")) {
    if (!may_have_knots(law)) node["knots"].refuse("only stiffness splines have knots");
    for (const Node& knot : node["knots"].list()) law.knots.push_back(knot.number());
  }
  if (row->spline) {
    // a spline has as many control points as the document lists
    const Node points = node["parameters"];
    points.expect_object();
    const int count = static_cast<int>(std::min<std::size_t>(points.keys().size(), 1000));
    law.parameters = read_parameters(points, default_parameters(*row, count, domain));
  } else if (node.has("parameters")) {
    law.parameters = read_parameters(node["parameters"], default_parameters(*row, 0, domain));
  } else {
    law.parameters = default_parameters(*row, 0, domain);
  }
  return law;
}

Term read_term(const Node& node) {
  node.expect_object({"id", "effect", "strain", "law", "support"});
  Term term;
  term.id = node["id"].text();
  term.effect = node.text_or("effect", "");
  const Node strain = node["strain"];
  strain.expect_object({"name", "angle_rad", "elevation_rad"});
  term.strain.name = strain["name"].text();
  const StrainRow* row = find_strain(term.strain.name);
  if (row == nullptr) {
    std::string known;
    for (const StrainRow& r : strain_catalogue())
      known += (known.empty() ? "" : ", ") + std::string(r.name);
    strain["name"].refuse("there is no strain measure '" + term.strain.name +
                          "'; the measures are " + known);
  }
  if (strain.has("angle_rad")) term.strain.angle_rad = strain["angle_rad"].number();
  if (strain.has("elevation_rad")) term.strain.elevation_rad = strain["elevation_rad"].number();
  term.law = read_law(node["law"], row->domain);
  if (node.has("support")) {
    const Node support = node["support"];
    support.expect_object({"name", "field", "sample"});
    term.support.name = support["name"].text();
    term.support.field = support.text_or("field", "");
    if (support.has("sample")) term.support.sample = support["sample"].index();
  }
  return term;
}

Field read_field(const Node& node) {
  node.expect_object({"id", "positions_m", "width_m"});
  Field field;
  field.id = node["id"].text();
  field.width_m = node["width_m"].number();
  const std::vector<Node> positions = node["positions_m"].list();
  if (positions.empty()) node["positions_m"].refuse("a field needs at least one sample");
  field.dimensions = static_cast<int>(positions.front().list().size());
  if (field.dimensions != 2 && field.dimensions != 3)
    positions.front().refuse("a position has 2 numbers on cloth, 3 in a solid");
  for (const Node& position : positions) {
    const std::vector<Node> numbers = position.list();
    if (static_cast<int>(numbers.size()) != field.dimensions)
      position.refuse("must have as many numbers as the first position");
    for (const Node& number : numbers) field.positions_m.push_back(number.number());
  }
  return field;
}

/// A unit that is left out is that of the model's terms.
EnergyLimit read_limit(const Node& node, const std::string& unit) {
  node.expect_object({"id", "terms", "energy_max"});
  EnergyLimit limit;
  limit.id = node["id"].text();
  const Node terms = node["terms"];
  if (!terms.is_text()) {
    limit.terms = terms.texts();
    if (limit.terms.empty()) terms.refuse("must name a term, or be 'all'");
  } else if (terms.text() != "all") {
    terms.refuse("must be a list of terms or 'all', not '" + terms.text() + "'");
  }
  const Node energy = node["energy_max"];
  limit.unit = unit;
  if (energy.is_number()) {
    limit.energy_max = energy.number();
    return limit;
  }
  if (!energy.is_object()) energy.refuse("must be a number, or an object with the key 'value'");
  energy.expect_object({"value", "unit"});
  limit.energy_max = energy["value"].number();
  limit.unit = energy.text_or("unit", unit);
  return limit;
}

/// Whether a row has all parameters that a document gives, in the units that it gives.
bool may_be(const CorrectionRow& row, const Node& parameters) {
  for (const std::string& key : parameters.keys()) {
    const Node parameter = parameters.child(key);
    const auto same = [&](const ParameterRow& known) {
      return known.name == key &&
             (!parameter.is_object() ||
              parameter.text_or("unit", std::string(known.unit)) == std::string(known.unit));
    };
    if (std::none_of(row.parameters.begin(), row.parameters.end(), same)) return false;
  }
  return true;
}

/// Of curves, or of sheets where only their row has what the document gives.
const CorrectionRow* correction_row(const Node& node, const std::string& type) {
  const CorrectionRow* of_curves = find_correction(type, Seen::curves);
  const CorrectionRow* of_sheets = find_correction(type, Seen::sheets);
  if (of_curves == nullptr || of_sheets == nullptr) return of_curves ? of_curves : of_sheets;
  if (!node.has("parameters")) return of_curves;
  const Node parameters = node["parameters"];
  parameters.expect_object();
  return !may_be(*of_curves, parameters) && may_be(*of_sheets, parameters) ? of_sheets : of_curves;
}

SensorCorrection read_correction(const Node& node) {
  node.expect_object({"id", "effect", "type", "capture", "component", "parameters"});
  SensorCorrection correction;
  correction.id = node["id"].text();
  correction.effect = node.text_or("effect", "");
  correction.type = node["type"].text();
  correction.capture = node.text_or("capture", "");
  correction.component = node.text_or("component", "");
  const CorrectionRow* row = correction_row(node, correction.type);
  if (row == nullptr)
    node["type"].refuse("there is no sensor correction '" + correction.type + "'");
  correction.parameters = default_parameters(*row);
  if (node.has("parameters"))
    correction.parameters = read_parameters(node["parameters"], correction.parameters);
  return correction;
}

Model read_model(const Node& root) {
  if (!root.is_object()) root.refuse("a model document must be a JSON object");
  if (root["schema"].text() != "tenter.model")
    root["schema"].refuse("must be 'tenter.model', not '" + root["schema"].text() + "'");
  if (root["version"].number() != 1)
    root["version"].refuse("this program reads version 1 of the model document");
  root.expect_object({"schema", "version", "name", "description", "terms", "fields", "limits",
                      "corrections", "strain_ranges", "lineage"});
  Model model;
  model.name = root["name"].text();
  model.description = root.text_or("description", "");
  for (const Node& term : root["terms"].list()) model.terms.push_back(read_term(term));
  if (root.has("fields"))
    for (const Node& field : root["fields"].list()) model.fields.push_back(read_field(field));
  if (root.has("limits") && !model.terms.empty()) {
    const StrainRow* row = find_strain(model.terms.front().strain.name);
    for (const Node& limit : root["limits"].list())
      model.limits.push_back(read_limit(limit, std::string(energy_density_unit(row->domain))));
  }
  if (root.has("corrections"))
    for (const Node& correction : root["corrections"].list())
      model.corrections.push_back(read_correction(correction));
  if (root.has("strain_ranges"))
    for (const Node& range : root["strain_ranges"].list()) {
      range.expect_object({"term", "lo", "hi"});
      model.strain_ranges.push_back(
          {range["term"].text(), range["lo"].number(), range["hi"].number()});
    }
  if (root.has("lineage")) {
    const Node lineage = root["lineage"];
    lineage.expect_object({"parent", "added", "captures"});
    model.lineage = Lineage{lineage.text_or("parent", ""), {}, {}};
    if (lineage.has("added")) model.lineage->added = lineage["added"].texts();
    if (lineage.has("captures")) model.lineage->captures = lineage["captures"].texts();
  }
  return model;
}

}  // namespace

Expected<Model> parse_model(std::string_view json_text, std::string_view source_name) {
  auto model = read_document(json_text, source_name, kMaxDocumentBytes, read_model);
  if (!model) return model;
  if (auto checked = validate(*model); !checked)
    return fail(checked.error().kind, std::string(source_name) + ": " + checked.error().message);
  return model;
}

}  // namespace tenter::model
