// SPDX-License-Identifier: Apache-2.0
// Private: cells of a CSV as numbers; what is none is said with file, line and column.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/error.h"
#include "common/capture/csv/csv_table.h"

namespace tenter::capture {

class CsvCells {
 public:
  /// `csv` and `json` are what messages call the table and its description; all must outlive this.
  CsvCells(const CsvTable& table, const std::string& csv, const std::string& json,
           bool decimal_comma)
      : table_(table), csv_(csv), json_(json), decimal_comma_(decimal_comma) {}

  /// "FILE: line 3, column "x": WHAT."
  tl::unexpected<Error> at(std::size_t row, const std::string& column,
                           const std::string& what) const;

  /// NaN where the cell is blank and may be.
  Expected<double> number(std::size_t row, const std::string& column, std::string text,
                          bool may_be_missing) const;
  Expected<int> whole_number(std::size_t row, const std::string& column,
                             const std::string& text) const;

 private:
  const CsvTable& table_;
  const std::string& csv_;
  const std::string& json_;
  bool decimal_comma_;
};

}  // namespace tenter::capture
