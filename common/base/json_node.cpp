// SPDX-License-Identifier: Apache-2.0
#include "common/base/json_node.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace tenter {

namespace {

constexpr int kMaxDepth = 64;

std::string line_and_column(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t start = before.rfind('\n');
  const std::size_t column =
      start == std::string_view::npos ? before.size() : before.size() - start - 1;
  return "line " + std::to_string(line) + ", column " +
         std::to_string(std::max<std::size_t>(column, 1));
}

}  // namespace

std::string JsonNode::must_be(const char* what) const {
  const std::string found = json_->type_name();
  const char* article = json_->is_null() ? "" : json_->is_structured() ? "an " : "a ";
  return std::string("must be ") + what + ", not " + article + found;
}

void JsonNode::expect_object() const {
  if (!json_->is_object()) refuse(must_be("an object"));
}

void JsonNode::expect_object(std::initializer_list<std::string_view> keys) const {
  expect_object();
  for (const auto& [key, value] : json_->items())
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
      std::string known;
      for (const std::string_view k : keys) known += (known.empty() ? "" : ", ") + std::string(k);
      child(key).refuse("unknown key; known here are " + known);
    }
}

JsonNode JsonNode::child(const std::string& key) const {
  const auto found = json_->find(key);
  return JsonNode(found == json_->end() ? *json_ : *found, path_.empty() ? key : path_ + "." + key);
}

JsonNode JsonNode::operator[](const char* key) const {
  expect_object();
  if (!has(key)) refuse("the key '" + std::string(key) + "' is missing");
  return child(key);
}

std::vector<std::string> JsonNode::keys() const {
  std::vector<std::string> names;
  for (const auto& item : json_->items()) names.push_back(item.key());
  return names;
}

std::vector<JsonNode> JsonNode::list() const {
  if (!json_->is_array()) refuse(must_be("a list"));
  std::vector<JsonNode> nodes;
  for (std::size_t i = 0; i < json_->size(); ++i)
    nodes.emplace_back((*json_)[i], path_ + "[" + std::to_string(i) + "]");
  return nodes;
}

std::string JsonNode::text() const {
  if (!json_->is_string()) refuse(must_be("a string"));
  return json_->get<std::string>();
}

double JsonNode::number() const {
  if (!json_->is_number()) refuse(must_be("a number"));
  return json_->get<double>();
}

bool JsonNode::boolean() const {
  if (!json_->is_boolean()) refuse(must_be("true or false"));
  return json_->get<bool>();
}

int JsonNode::whole(int least, int most) const {
  const double value = number();
  if (!(value >= least && value <= most) || value != std::floor(value))
    refuse("must be a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  return static_cast<int>(value);
}

int JsonNode::index() const {
  const double value = number();
  if (!(value >= 1.0 && value <= 1e6) || value != std::floor(value))
    refuse("must be a whole number from 1 on");
  return static_cast<int>(value);
}

std::optional<double> JsonNode::number_or_null() const {
  if (is_null()) return std::nullopt;
  return number();
}

std::pair<double, double> JsonNode::pair() const {
  const std::vector<JsonNode> ends = list();
  if (ends.size() != 2) refuse("must hold two numbers");
  return {ends[0].number(), ends[1].number()};
}

std::vector<std::string> JsonNode::texts() const {
  std::vector<std::string> values;
  for (const JsonNode& node : list()) values.push_back(node.text());
  return values;
}

nlohmann::ordered_json parse_document(std::string_view text) {
  using Json = nlohmann::ordered_json;
  // JSON allows a key twice in one object and keeps the last; here that is a mistake of the writer
  std::vector<std::set<std::string>> seen;
  const Json::parser_callback_t watch = [&seen](int depth, Json::parse_event_t event, Json& value) {
    if (depth > kMaxDepth) throw BadKey{"is nested too deeply"};
    if (event == Json::parse_event_t::object_start) seen.emplace_back();
    if (event == Json::parse_event_t::object_end) seen.pop_back();
    if (event == Json::parse_event_t::key && !seen.back().insert(value.get<std::string>()).second)
      throw BadKey{"the key '" + value.get<std::string>() + "' appears twice in one object"};
    return true;
  };
  try {
    return Json::parse(text, watch);
  } catch (const nlohmann::detail::parse_error& broken) {
    throw BadKey{"is not JSON, see " + line_and_column(text, broken.byte)};
  }
}

}  // namespace tenter
