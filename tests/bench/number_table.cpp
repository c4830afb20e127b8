// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/number_table.h"

#include <charconv>

#include "common/base/text_file.h"
#include "common/capture/csv/csv_table.h"

namespace tenter::bench {

Expected<std::vector<std::vector<double>>> read_numbers(const std::string& path,
                                                        const std::vector<std::string>& columns) {
  constexpr std::size_t kMostBytes = 500'000'000;
  const auto text = read_text_file(path, kMostBytes);
  if (!text) return tl::unexpected(text.error());
  const auto table = capture::parse_csv(*text, {}, path);
  if (!table) return tl::unexpected(table.error());
  if (table->row_count() == 0) return bad_input(path + ": has no rows");
  std::vector<std::vector<double>> rows(table->row_count());
  for (const std::string& name : columns) {
    const std::size_t column = table->find(name);
    if (column == table->header.size()) return bad_input(path + ": has no column " + name);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const std::string& cell = table->cell(row, column);
      double value = 0.0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (error != std::errc{} || end != cell.data() + cell.size())
        return bad_input(path + ": line " + std::to_string(table->lines[row]) + ", column " + name +
                         ": \"" + cell + "\" is no number");
      rows[row].push_back(value);
    }
  }
  return rows;
}

}  // namespace tenter::bench
