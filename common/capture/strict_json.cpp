// SPDX-License-Identifier: Apache-2.0
#include "common/capture/strict_json.h"

#include <algorithm>
#include <cmath>

#include "common/capture/units.h"

namespace tenter::capture {

using nlohmann::json;

namespace {

const json& empty_object() {
  static const json object = json::object();
  return object;
}

}  // namespace

Expected<json> parse_json(const std::string& text, const std::string& name) {
  constexpr int kMaxDepth = 32;
  std::vector<std::set<std::string>> keys;
  std::string trouble;
  const auto watch = [&](int depth, json::parse_event_t event, json& parsed) {
    if (depth > kMaxDepth && trouble.empty()) trouble = "is nested more than 32 levels deep";
    if (event == json::parse_event_t::object_start) keys.emplace_back();
    if (event == json::parse_event_t::object_end) keys.pop_back();
    if (event == json::parse_event_t::key &&
        !keys.back().insert(parsed.get<std::string>()).second && trouble.empty())
      trouble = "has the key \"" + parsed.get<std::string>() + "\" twice in one object";
    return trouble.empty();
  };
  try {
    json document = json::parse(text, watch);
    if (!trouble.empty()) return bad_input(name + ": " + trouble + ".");
    return document;
  } catch (const json::parse_error& error) {
    if (!trouble.empty()) return bad_input(name + ": " + trouble + ".");
    const std::size_t at = std::min<std::size_t>(error.byte == 0 ? 0 : error.byte - 1, text.size());
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    return bad_input(name + ": line " + std::to_string(line) + " is not valid JSON.");
  }
}

JsonObject::JsonObject(const json& value, std::string path, JsonDefect& defect)
    : value_(&value), path_(std::move(path)), defect_(defect) {
  if (value.is_object()) return;
  defect_.note(path_, "must be an object");
  value_ = &empty_object();
}

bool JsonObject::has(const std::string& key) const {
  return value_->contains(key);
}

std::string JsonObject::path_of(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

std::vector<std::string> JsonObject::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, value] : value_->items()) names.push_back(key);
  return names;
}

const json* JsonObject::raw(const std::string& key) {
  const auto found = value_->find(key);
  if (found == value_->end()) return nullptr;
  read_.insert(key);
  return &*found;
}

std::string JsonObject::text(const std::string& key) {
  if (!has(key)) defect_.note(path_of(key), "is missing");
  return text_or(key, "");
}

std::string JsonObject::text_or(const std::string& key, const std::string& otherwise) {
  return maybe_text(key).value_or(otherwise);
}

std::optional<std::string> JsonObject::maybe_text(const std::string& key) {
  const json* value = raw(key);
  if (!value) return std::nullopt;
  if (value->is_string()) return value->get<std::string>();
  defect_.note(path_of(key), "must be a text");
  return std::nullopt;
}

double JsonObject::number(const std::string& key) {
  if (!has(key)) defect_.note(path_of(key), "is missing");
  return maybe_number(key).value_or(0.0);
}

std::optional<double> JsonObject::maybe_number(const std::string& key) {
  const json* value = raw(key);
  if (!value) return std::nullopt;
  if (value->is_number() && std::isfinite(value->get<double>())) return value->get<double>();
  defect_.note(path_of(key), "must be a number");
  return std::nullopt;
}

bool JsonObject::flag_or(const std::string& key, bool otherwise) {
  const json* value = raw(key);
  if (!value) return otherwise;
  if (value->is_boolean()) return value->get<bool>();
  defect_.note(path_of(key), "must be true or false");
  return otherwise;
}

JsonObject JsonObject::object(const std::string& key) {
  if (!has(key)) defect_.note(path_of(key), "is missing");
  const json* value = raw(key);
  return JsonObject(value ? *value : empty_object(), path_of(key), defect_);
}

std::optional<JsonObject> JsonObject::maybe_object(const std::string& key) {
  const json* value = raw(key);
  if (!value) return std::nullopt;
  return JsonObject(*value, path_of(key), defect_);
}

std::vector<JsonObject> JsonObject::objects(const std::string& key) {
  std::vector<JsonObject> list;
  const json* value = raw(key);
  if (!value) return list;
  if (!value->is_array()) {
    defect_.note(path_of(key), "must be a list");
    return list;
  }
  for (std::size_t i = 0; i < value->size(); ++i)
    list.emplace_back((*value)[i], path_of(key) + "[" + std::to_string(i) + "]", defect_);
  return list;
}

std::vector<std::string> JsonObject::texts(const std::string& key) {
  const json* value = raw(key);
  if (!value) return {};
  if (value->is_string()) return {value->get<std::string>()};
  std::vector<std::string> list;
  const bool ok =
      value->is_array() &&
      std::all_of(value->begin(), value->end(), [](const json& item) { return item.is_string(); });
  if (!ok) {
    defect_.note(path_of(key), "must be a text or a list of texts");
    return {};
  }
  for (const json& item : *value) list.push_back(item.get<std::string>());
  return list;
}

std::optional<double> JsonObject::maybe_measure(const std::string& key,
                                                const std::string& si_unit) {
  std::optional<JsonObject> measure = maybe_object(key);
  if (!measure) return std::nullopt;
  const double value = measure->number("value");
  const std::string unit = measure->text("unit");
  measure->finish();
  if (defect_) return std::nullopt;
  const Expected<UnitConversion> to_si = conversion(unit, si_unit);
  if (!to_si) {
    defect_.note(measure->path_of("unit") + ":", to_si.error().message);
    return std::nullopt;
  }
  return to_si->apply(value);
}

void JsonObject::finish() {
  for (const auto& [key, value] : value_->items())
    if (read_.count(key) == 0) return defect_.note(path_of(key), "is not a known key");
}

}  // namespace tenter::capture
