// SPDX-License-Identifier: Apache-2.0
// Reading a result document that may lack keys or hold null: what is not there, or is of another
// type, is "none". For the source files of this folder only (it pulls in the whole JSON library).
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace tenter::report {

using Json = nlohmann::ordered_json;

inline const Json& member(const Json& object, const char* key) {
  static const Json none;
  if (!object.is_object()) return none;
  const auto found = object.find(key);
  return found == object.end() ? none : *found;
}

inline std::optional<double> number(const Json& value) {
  if (!value.is_number()) return std::nullopt;
  const double x = value.get<double>();
  return std::isfinite(x) ? std::optional<double>(x) : std::nullopt;
}
inline std::optional<double> number(const Json& object, const char* key) {
  return number(member(object, key));
}

inline std::string text(const Json& value) {
  return value.is_string() ? value.get<std::string>() : std::string();
}
inline std::string text(const Json& object, const char* key) {
  return text(member(object, key));
}

inline bool flag(const Json& object, const char* key) {
  const Json& value = member(object, key);
  return value.is_boolean() && value.get<bool>();
}

/// The list under `key`, or an empty one.
inline const Json& list(const Json& object, const char* key) {
  static const Json empty = Json::array();
  const Json& value = member(object, key);
  return value.is_array() ? value : empty;
}

}  // namespace tenter::report
