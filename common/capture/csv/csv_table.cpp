// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/csv_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>

namespace tenter::capture {

namespace {

constexpr std::size_t kMaxColumns = 20000;

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

/// One pass over the text; `line` is the line of the character at `at`.
class Parser {
 public:
  Parser(const std::string& text, char separator, const std::string& name)
      : text_(text), separator_(separator), name_(name) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  }

  bool at_end() const { return at_ >= text_.size(); }
  std::size_t line() const { return line_; }

  void skip_line() {
    while (!at_end() && text_[at_] != '\n') ++at_;
    if (!at_end()) take_newline();
  }

  /// Cells of the next line (of several, where quotes hold line ends).
  Expected<void> row(std::vector<std::string>* cells) {
    cells->clear();
    for (;;) {
      std::string cell;
      if (auto ok = one_cell(&cell); !ok) return ok;
      cells->push_back(std::move(cell));
      if (cells->size() > kMaxColumns) return complaint("has more than 20000 columns");
      if (at_end()) return {};
      if (at_newline()) {
        take_newline();
        return {};
      }
      ++at_;  // the separator
    }
  }

 private:
  tl::unexpected<Error> complaint(const std::string& what) const {
    return bad_input(name_ + ": line " + std::to_string(line_) + " " + what + ".");
  }

  bool at_newline() const {
    return text_[at_] == '\n' ||
           (text_[at_] == '\r' && (at_ + 1 == text_.size() || text_[at_ + 1] == '\n'));
  }
  void take_newline() {
    if (text_[at_] == '\r') ++at_;
    if (!at_end() && text_[at_] == '\n') ++at_;
    ++line_;
  }
  bool at_cell_end() const { return at_end() || text_[at_] == separator_ || at_newline(); }
  void skip_blanks() {
    while (!at_end() && is_blank(text_[at_]) && text_[at_] != separator_) ++at_;
  }

  Expected<void> one_cell(std::string* cell) {
    skip_blanks();
    if (!at_end() && text_[at_] == '"') return quoted_cell(cell);
    const std::size_t begin = at_;
    while (!at_cell_end()) {
      if (text_[at_] == '"') return complaint("has a quote in the middle of a cell");
      if (text_[at_] == '\0') return complaint("holds a zero byte; this is not a text file");
      ++at_;
    }
    std::size_t end = at_;
    while (end > begin && is_blank(text_[end - 1])) --end;
    cell->assign(text_, begin, end - begin);
    return {};
  }

  Expected<void> quoted_cell(std::string* cell) {
    const std::size_t opened = line_;
    for (++at_;; ++at_) {
      if (at_end())
        return bad_input(name_ + ": line " + std::to_string(opened) +
                         " opens a quote that is never closed.");
      if (text_[at_] == '"') {
        ++at_;
        if (at_end() || text_[at_] != '"') break;
      }
      if (text_[at_] == '\0') return complaint("holds a zero byte; this is not a text file");
      if (text_[at_] == '\n') ++line_;
      cell->push_back(text_[at_]);
    }
    skip_blanks();
    if (!at_cell_end()) return complaint("has text after a closing quote");
    return {};
  }

  const std::string& text_;
  char separator_;
  const std::string& name_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

Expected<void> check_header(const std::vector<std::string>& header, std::size_t line,
                            const std::string& name) {
  const std::string where = name + ": line " + std::to_string(line);
  std::set<std::string> seen;
  for (std::size_t i = 0; i < header.size(); ++i) {
    if (header[i].empty())
      return bad_input(where + ": column " + std::to_string(i + 1) + " of the header has no name.");
    if (!seen.insert(header[i]).second)
      return bad_input(where + ": the header names column \"" + header[i] + "\" twice.");
  }
  return {};
}

}  // namespace

std::size_t CsvTable::find(const std::string& name) const {
  return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
}

Expected<CsvTable> parse_csv(const std::string& text, const CsvOptions& options,
                             const std::string& name) {
  Parser parser(text, options.separator, name);
  for (std::size_t i = 0; i < options.skip_lines; ++i) parser.skip_line();
  CsvTable table;
  std::vector<std::string> cells;
  std::size_t rows = 0;
  while (!parser.at_end()) {
    const std::size_t line = parser.line();
    if (auto ok = parser.row(&cells); !ok) return tl::unexpected(ok.error());
    if (cells.size() == 1 && cells[0].empty()) continue;
    if (table.header.empty()) {
      if (auto ok = check_header(cells, line, name); !ok) return tl::unexpected(ok.error());
      table.header = cells;
      continue;
    }
    if (rows++ < options.skip_rows) continue;
    if (cells.size() != table.header.size())
      return bad_input(name + ": line " + std::to_string(line) + " has " +
                       std::to_string(cells.size()) + " cells where the header has " +
                       std::to_string(table.header.size()) + ".");
    table.lines.push_back(line);
    std::move(cells.begin(), cells.end(), std::back_inserter(table.cells));
  }
  if (table.header.empty()) return bad_input(name + ": has no header line.");
  return table;
}

std::string csv_cell(const std::string& text, char separator) {
  const bool plain = std::none_of(text.begin(), text.end(), [separator](char c) {
    return c == separator || c == '"' || c == '\n' || c == '\r';
  });
  const bool trimmed = text.empty() || (!is_blank(text.front()) && !is_blank(text.back()));
  if (plain && trimmed) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted.push_back('"');
    quoted.push_back(c);
  }
  return quoted + "\"";
}

std::string csv_number(double value) {
  if (std::isnan(value)) return "";
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return std::string(text.data(), end);
}

}  // namespace tenter::capture
