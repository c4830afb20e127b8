// SPDX-License-Identifier: Apache-2.0
// Private: reads a JSON document key by key, refuses what nobody asked for, and names every defect
// by its path.
//
//   JsonDefect defect;
//   JsonObject root(document, "", defect);
//   std::string title = root.text("title");
//   root.finish();                         // a key that was not read is a defect
//   if (defect) return bad_input(file + ": " + defect.sentence() + ".");
//
// The first defect is kept; reading goes on with empty values, so that a reader is a plain list of
// keys.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace tenter::capture {

/// Parses a document: no duplicate keys, no more than 32 levels. Errors name line and column.
Expected<nlohmann::json> parse_json(const std::string& text, const std::string& name);

class JsonDefect {
 public:
  void note(const std::string& path, const std::string& what) {
    if (sentence_.empty())
      sentence_ = (path.empty() ? std::string("the document") : path) + " " + what;
  }
  explicit operator bool() const { return !sentence_.empty(); }
  const std::string& sentence() const { return sentence_; }

 private:
  std::string sentence_;
};

class JsonObject {
 public:
  JsonObject(const nlohmann::json& value, std::string path, JsonDefect& defect);

  bool has(const std::string& key) const;
  std::string path_of(const std::string& key) const;
  JsonDefect& defect() const { return defect_; }
  std::vector<std::string> keys() const;

  // required values
  std::string text(const std::string& key);
  double number(const std::string& key);
  JsonObject object(const std::string& key);

  // optional values
  std::string text_or(const std::string& key, const std::string& otherwise);
  bool flag_or(const std::string& key, bool otherwise);
  std::optional<double> maybe_number(const std::string& key);
  std::optional<std::string> maybe_text(const std::string& key);
  std::optional<JsonObject> maybe_object(const std::string& key);
  std::vector<JsonObject> objects(const std::string& key);
  /// A text or a list of texts; nothing where the key is absent.
  std::vector<std::string> texts(const std::string& key);
  /// {"value": 80, "unit": "mm"} turned into `si_unit`.
  std::optional<double> maybe_measure(const std::string& key, const std::string& si_unit);

  /// The raw value, marked as read.
  const nlohmann::json* raw(const std::string& key);

  /// Notes a defect for the first key that was never read.
  void finish();

 private:
  const nlohmann::json* value_;
  std::string path_;
  JsonDefect& defect_;
  std::set<std::string> read_;
};

}  // namespace tenter::capture
