// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/csv_cells.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace tenter::capture {

tl::unexpected<Error> CsvCells::at(std::size_t row, const std::string& column,
                                   const std::string& what) const {
  return bad_input(csv_ + ": line " + std::to_string(table_.lines[row]) + ", column \"" + column +
                   "\": " + what + ".");
}

Expected<double> CsvCells::number(std::size_t row, const std::string& column, std::string text,
                                  bool may_be_missing) const {
  if (text.empty()) {
    if (may_be_missing) return std::numeric_limits<double>::quiet_NaN();
    return at(row, column, "is blank, and " + json_ + " does not declare missing values there");
  }
  if (decimal_comma_) std::replace(text.begin(), text.end(), ',', '.');
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0);
  const char* end = text.data() + text.size();
  double value = 0.0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (stop != end || error == std::errc::invalid_argument)
    return at(
        row, column,
        "\"" + text.substr(0, 40) + "\" is not a number" +
            (row == 0 ? "; \"skip_rows\": 1 in " + json_ + " leaves out a row of units" : ""));
  if (error == std::errc::result_out_of_range || std::isinf(value))
    return at(row, column, "\"" + text.substr(0, 40) + "\" is too large or too small");
  if (std::isnan(value) && !may_be_missing)
    return at(row, column, "is NaN, and " + json_ + " does not declare missing values there");
  return value;
}

Expected<int> CsvCells::whole_number(std::size_t row, const std::string& column,
                                     const std::string& text) const {
  int value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || stop != text.data() + text.size())
    return at(row, column, "\"" + text.substr(0, 40) + "\" is not a whole number");
  return value;
}

}  // namespace tenter::capture
