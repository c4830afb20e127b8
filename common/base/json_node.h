// SPDX-License-Identifier: Apache-2.0
// Reads a JSON document that a person may have written: a JsonNode knows the path that leads to it,
// and every refusal names that path and the reason.
//
//   return read_document(text, "fabric.json", kMaxBytes, [](const JsonNode& root) {
//     root.expect_object({"name", "size"});
//     return Fabric{root["name"].text(), root["size"].number()};
//   });
//   // error: "fabric.json: size: must be a number, not a string"
//
// A bad key ends the walk at once: refuse() throws BadKey, which read_document turns into an Error.
// Keys that appear twice in one object are refused, as are documents nested deeper than 64 levels.
// Who needs it: common/model and common/scene. Pure; any thread.
#pragma once

#include <array>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/error.h"

namespace tenter {

struct BadKey {
  std::string message;
};

/// A value of the document and the path that leads to it; refers to the document.
class JsonNode {
 public:
  using Json = nlohmann::ordered_json;
  JsonNode(const Json& json, std::string path) : json_(&json), path_(std::move(path)) {}

  [[noreturn]] void refuse(const std::string& reason) const {
    throw BadKey{path_.empty() ? reason : path_ + ": " + reason};
  }

  const std::string& path() const { return path_; }
  const Json& json() const { return *json_; }
  bool is_null() const { return json_->is_null(); }
  bool is_object() const { return json_->is_object(); }
  bool is_list() const { return json_->is_array(); }
  bool is_text() const { return json_->is_string(); }
  bool is_number() const { return json_->is_number(); }

  /// Refuses anything but an object, or one with other keys.
  void expect_object() const;
  void expect_object(std::initializer_list<std::string_view> keys) const;

  bool has(const char* key) const { return json_->contains(key); }
  JsonNode child(const std::string& key) const;
  JsonNode operator[](const char* key) const;  ///< refuses where it is missing
  std::vector<std::string> keys() const;
  std::vector<JsonNode> list() const;

  std::string text() const;
  double number() const;
  bool boolean() const;
  /// A whole number within bounds.
  int whole(int least, int most) const;
  /// A whole number from 1 on.
  int index() const;
  std::optional<double> number_or_null() const;
  std::pair<double, double> pair() const;
  template <std::size_t N>
  std::array<double, N> numbers() const {
    const std::vector<JsonNode> nodes = list();
    if (nodes.size() != N) refuse("must hold " + std::to_string(N) + " numbers");
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) values[i] = nodes[i].number();
    return values;
  }
  std::vector<std::string> texts() const;

  std::string text_or(const char* key, const std::string& otherwise) const {
    return has(key) ? child(key).text() : otherwise;
  }
  double number_or(const char* key, double otherwise) const {
    return has(key) ? child(key).number() : otherwise;
  }

 private:
  std::string must_be(const char* what) const;

  const Json* json_;
  std::string path_;
};

/// Refuses (BadKey) what is not JSON, with line and column.
nlohmann::ordered_json parse_document(std::string_view text);

/// `read` walks the document; what it throws of BadKey and of the JSON library becomes bad_input,
/// "SOURCE: path: reason".
template <class Read>
auto read_document(std::string_view text, std::string_view source, std::size_t max_bytes, Read read)
    -> Expected<decltype(read(std::declval<const JsonNode&>()))> {
  const std::string name = std::string(source) + ": ";
  if (text.size() > max_bytes)
    return bad_input(name + "a document here may have " + std::to_string(max_bytes >> 20) +
                     " MiB, this one has " + std::to_string(text.size()) + " bytes");
  try {
    const nlohmann::ordered_json json = parse_document(text);
    return read(JsonNode(json, ""));
  } catch (const BadKey& bad) {
    return bad_input(name + bad.message);
  } catch (const nlohmann::detail::exception&) {
    return bad_input(name + "holds a number that is too large, or text that is not UTF-8");
  }
}

}  // namespace tenter
