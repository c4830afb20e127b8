// SPDX-License-Identifier: Apache-2.0
// Reading walks the document with a Node that knows its own path. A bad key ends the walk at once:
// BadKey is thrown and caught in this file only, and becomes the Error of parse_model.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <set>

#include "common/model/catalogue.h"
#include "common/model/document.h"

namespace tenter::model {

namespace {

using Json = nlohmann::ordered_json;

struct BadKey {
  std::string message;
};

/// A value of the document and the path that leads to it.
class Node {
 public:
  Node(const Json& json, std::string path) : json_(&json), path_(std::move(path)) {}

  [[noreturn]] void refuse(const std::string& reason) const {
    throw BadKey{path_.empty() ? reason : path_ + ": " + reason};
  }

  bool is_null() const { return json_->is_null(); }
  bool is_object() const { return json_->is_object(); }
  const std::string& path() const { return path_; }

  /// Refuses anything but an object with these keys.
  void expect_object(std::initializer_list<std::string_view> keys) const {
    expect_object();
    for (const auto& [key, value] : json_->items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
        std::string known;
        for (const std::string_view k : keys) known += (known.empty() ? "" : ", ") + std::string(k);
        child(key).refuse("unknown key; known here are " + known);
      }
  }
  void expect_object() const {
    if (!json_->is_object()) refuse(must_be("an object"));
  }

  bool has(const char* key) const { return json_->contains(key); }
  Node child(const std::string& key) const {
    const auto found = json_->find(key);
    return Node(found == json_->end() ? *json_ : *found, path_.empty() ? key : path_ + "." + key);
  }
  Node operator[](const char* key) const {
    if (!has(key)) refuse("the key '" + std::string(key) + "' is missing");
    return child(key);
  }
  std::vector<std::string> keys() const {
    std::vector<std::string> names;
    for (const auto& item : json_->items()) names.push_back(item.key());
    return names;
  }
  std::vector<Node> list() const {
    if (!json_->is_array()) refuse(must_be("a list"));
    std::vector<Node> nodes;
    for (std::size_t i = 0; i < json_->size(); ++i)
      nodes.emplace_back((*json_)[i], path_ + "[" + std::to_string(i) + "]");
    return nodes;
  }

  std::string text() const {
    if (!json_->is_string()) refuse(must_be("a string"));
    return json_->get<std::string>();
  }
  double number() const {
    if (!json_->is_number()) refuse(must_be("a number"));
    return json_->get<double>();
  }
  bool is_number() const { return json_->is_number(); }
  bool is_text() const { return json_->is_string(); }
  /// A whole number from 1 on.
  int index() const {
    const double value = number();
    if (!(value >= 1.0 && value <= 1e6) || value != std::floor(value))
      refuse("must be a whole number from 1 on");
    return static_cast<int>(value);
  }
  bool boolean() const {
    if (!json_->is_boolean()) refuse(must_be("true or false"));
    return json_->get<bool>();
  }
  std::optional<double> number_or_null() const {
    if (is_null()) return std::nullopt;
    return number();
  }
  std::pair<double, double> pair() const {
    const std::vector<Node> ends = list();
    if (ends.size() != 2) refuse("must hold two numbers");
    return {ends[0].number(), ends[1].number()};
  }
  std::string text_or(const char* key, const std::string& otherwise) const {
    return has(key) ? child(key).text() : otherwise;
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> values;
    for (const Node& node : list()) values.push_back(node.text());
    return values;
  }

 private:
  std::string must_be(const char* what) const {
    const std::string found = json_->type_name();
    const char* article = json_->is_null() ? "" : json_->is_structured() ? "an " : "a ";
    return std::string("must be ") + what + ", not " + article + found;
  }

  const Json* json_;
  std::string path_;
};

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
  node.expect_object({"name", "range", "parameters"});
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

SensorCorrection read_correction(const Node& node) {
  node.expect_object({"id", "effect", "type", "capture", "component", "parameters"});
  SensorCorrection correction;
  correction.id = node["id"].text();
  correction.effect = node.text_or("effect", "");
  correction.type = node["type"].text();
  correction.capture = node.text_or("capture", "");
  correction.component = node.text_or("component", "");
  const CorrectionRow* row = find_correction(correction.type);
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

std::string line_and_column(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t start = before.rfind('\n');
  const std::size_t column =
      start == std::string_view::npos ? before.size() : before.size() - start - 1;
  return "line " + std::to_string(line) + ", column " +
         std::to_string(std::max<std::size_t>(column, 1));
}

/// JSON allows a key twice in one object and keeps the last; here that is a mistake of the writer.
Json parse_json(std::string_view text) {
  std::vector<std::set<std::string>> seen;
  const Json::parser_callback_t watch = [&seen](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) seen.emplace_back();
    if (event == Json::parse_event_t::object_end) seen.pop_back();
    if (event == Json::parse_event_t::key && !seen.back().insert(value.get<std::string>()).second)
      throw BadKey{"the key '" + value.get<std::string>() + "' appears twice in one object"};
    return true;
  };
  return Json::parse(text, watch);
}

}  // namespace

Expected<Model> parse_model(std::string_view json_text, std::string_view source_name) {
  const std::string source = std::string(source_name) + ": ";
  if (json_text.size() > kMaxDocumentBytes)
    return bad_input(source + "a model document may have 4 MiB, this one has " +
                     std::to_string(json_text.size()) + " bytes");
  try {
    const Json json = parse_json(json_text);
    Model model = read_model(Node(json, ""));
    if (auto checked = validate(model); !checked)
      return fail(checked.error().kind, source + checked.error().message);
    return model;
  } catch (const BadKey& bad) {
    return bad_input(source + bad.message);
  } catch (const nlohmann::detail::parse_error& broken) {
    return bad_input(source + "is not JSON, see " + line_and_column(json_text, broken.byte));
  } catch (const nlohmann::detail::exception&) {
    return bad_input(source + "holds a number that is too large, or text that is not UTF-8");
  }
}

}  // namespace tenter::model
