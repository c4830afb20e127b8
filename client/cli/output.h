// SPDX-License-Identifier: Apache-2.0
// What commands print: JSON values, tables, errors.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace tenter::cli {

using Json = nlohmann::ordered_json;

/// One value and a line feed on standard output.
void print_json(const Json& value);
void print_text(const std::string& text);

/// A server's or library's JSON text; one that is not JSON is an internal Error.
Expected<Json> parse_reply(const std::string& text);

/// "bad_input" and the like.
const char* kind_name(ErrorKind kind);

/// {"error": {"kind", "code", "message"}}
Json error_json(const Error& error);

/// Lines up cells in columns; cells lose control characters.
class Table {
 public:
  /// A name that begins with '>' makes a column of numbers, set to the right.
  explicit Table(std::vector<std::string> columns);
  void add(std::vector<std::string> row);
  std::string text() const;

 private:
  std::vector<std::string> names_;
  std::vector<bool> right_;
  std::vector<std::vector<std::string>> rows_;
};

/// A member as short text: strings as they are, numbers in six digits, none as "-".
std::string cell(const Json& object, const char* key);

/// A member in milliseconds since 1970 as local date and time; "" where there is none.
std::string clock_words(const Json& object, const char* key);

/// "1.4 MB", "12 s", "3 min 20 s".
std::string bytes_words(double bytes);
std::string seconds_words(double seconds);

}  // namespace tenter::cli
