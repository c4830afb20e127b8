// SPDX-License-Identifier: Apache-2.0
// Strict reading of a delimited text file: one header line, then rows of as many cells.
//
// RFC 4180 quoting; LF or CRLF; a UTF-8 mark at the start is skipped; cells are trimmed of blanks
// outside quotes; wholly empty lines are skipped. Anything else (a row of another length, an open
// quote, text after a closing quote, a zero byte, a header cell that is empty or appears twice) is
// an error naming the line.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/base/error.h"

namespace tenter::capture {

struct CsvOptions {
  char separator = ',';
  std::size_t skip_lines = 0;  ///< lines of a machine's preamble before the header
  std::size_t skip_rows = 0;   ///< rows under the header that hold no readings: units
};

struct CsvTable {
  std::vector<std::string> header;
  std::vector<std::string> cells;  ///< row after row, header.size() each
  std::vector<std::size_t> lines;  ///< line number of each row, from 1

  std::size_t row_count() const { return lines.size(); }
  const std::string& cell(std::size_t row, std::size_t column) const {
    return cells[row * header.size() + column];
  }
  /// Index of a header cell, or header.size().
  std::size_t find(const std::string& name) const;
};

/// `name` is what messages call the file.
Expected<CsvTable> parse_csv(const std::string& text, const CsvOptions& options,
                             const std::string& name);

/// The same cell, quoted where it must be.
std::string csv_cell(const std::string& text, char separator = ',');

/// Shortest text that reads back to the same double; "" for a missing value.
std::string csv_number(double value);

}  // namespace tenter::capture
