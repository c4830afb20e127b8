// SPDX-License-Identifier: Apache-2.0
#include "client/cli/output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>

#include "common/report/text_report.h"

namespace tenter::cli {

void print_json(const Json& value) {
  std::cout << value.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

void print_text(const std::string& text) {
  std::cout << text;
}

Expected<Json> parse_reply(const std::string& text) {
  Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded())
    return fail(ErrorKind::internal,
                "the server's answer is not JSON; server and command may be of different versions");
  return value;
}

const char* kind_name(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::internal:
      return "internal";
    case ErrorKind::bad_input:
      return "bad_input";
    case ErrorKind::not_found:
      return "not_found";
    case ErrorKind::refused:
      return "refused";
    case ErrorKind::unavailable:
      return "unavailable";
    case ErrorKind::no_space:
      return "no_space";
    case ErrorKind::job_failed:
      return "job_failed";
    case ErrorKind::cancelled:
      return "cancelled";
  }
  return "internal";
}

Json error_json(const Error& error) {
  return {{"error",
           {{"kind", kind_name(error.kind)},
            {"code", static_cast<int>(error.kind)},
            {"message", error.message}}}};
}

Table::Table(std::vector<std::string> columns) : names_(std::move(columns)) {
  for (std::string& name : names_) {
    right_.push_back(!name.empty() && name[0] == '>');
    if (right_.back()) name.erase(0, 1);
  }
}

void Table::add(std::vector<std::string> row) {
  row.resize(names_.size());
  for (std::string& text : row) text = report::printable(text);
  rows_.push_back(std::move(row));
}

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < names_.size(); ++c) {
    widths.push_back(report::columns(names_[c]));
    for (const auto& row : rows_) widths[c] = std::max(widths[c], report::columns(row[c]));
  }
  std::string out;
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string text;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::string gap(widths[c] - report::columns(cells[c]), ' ');
      text += right_[c] ? gap + cells[c] : cells[c] + gap;
      if (c + 1 < cells.size()) text += "  ";
    }
    text.erase(text.find_last_not_of(' ') + 1);
    out += text + "\n";
  };
  line(names_);
  for (const auto& row : rows_) line(row);
  return out;
}

std::string cell(const Json& object, const char* key) {
  if (!object.is_object() || !object.contains(key)) return "-";
  const Json& value = object[key];
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer()) return value.dump();
  if (value.is_number()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value.get<double>());
    return text;
  }
  if (value.is_null()) return "-";
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string clock_words(const Json& object, const char* key) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_number()) return "";
  const std::time_t seconds = static_cast<std::time_t>(object[key].get<double>() / 1000.0);
  std::tm local{};
  char text[40];
  if (localtime_r(&seconds, &local) == nullptr ||
      std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &local) == 0)
    return "";
  return text;
}

std::string bytes_words(double bytes) {
  static constexpr const char* kUnits[] = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < std::size(kUnits)) {
    bytes /= 1000.0;
    ++unit;
  }
  char text[40];
  std::snprintf(text, sizeof text, unit > 0 && bytes < 9.95 ? "%.1f %s" : "%.0f %s", bytes,
                kUnits[unit]);
  return text;
}

std::string seconds_words(double seconds) {
  char text[60];
  const long long whole = std::llround(std::clamp(seconds, 0.0, 3.0e9));
  if (seconds < 9.95)
    std::snprintf(text, sizeof text, "%.1f s", std::max(0.0, seconds));
  else if (whole < 60)
    std::snprintf(text, sizeof text, "%lld s", whole);
  else if (whole < 3600)
    std::snprintf(text, sizeof text, "%lld min %lld s", whole / 60, whole % 60);
  else if (whole < 86400)
    std::snprintf(text, sizeof text, "%lld h %lld min", whole / 3600, whole / 60 % 60);
  else
    std::snprintf(text, sizeof text, "%lld d %lld h", whole / 86400, whole / 3600 % 24);
  return text;
}

}  // namespace tenter::cli
