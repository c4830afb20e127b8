// SPDX-License-Identifier: Apache-2.0
// The tables that a description of a sheet names: opened once each, their rows found by run and
// frame, their cells as numbers in SI. Every message names file, line and column.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/capture/csv/csv_cells.h"
#include "common/capture/csv/csv_table.h"
#include "common/capture/sheet_import/sheet_description.h"

namespace tenter::capture {

struct OpenTable {
  std::string name;  ///< its path
  std::string sha256;
  CsvTable table;
};

/// Files are beside the CSV that the import was called with, which is also the one named "", else
/// beside the description.
class TableFolder {
 public:
  TableFolder(const std::string& json_path, std::string main_csv);

  const std::string& json() const { return json_; }
  std::string path_of(const std::string& file) const;
  /// `key` is what asks for it.
  Expected<const OpenTable*> open(const std::string& file, const CsvOptions& options,
                                  const std::string& key);

 private:
  std::string json_;
  std::string main_csv_;
  std::map<std::tuple<std::string, char, std::size_t, std::size_t>, std::unique_ptr<OpenTable>>
      open_;
};

/// Frames of the capture by what tables call them.
class FrameIndex {
 public:
  bool has_runs = false;  ///< the table of frames has a column for them
  std::size_t run_count = 1;
  void add(const std::string& run, int frame, std::size_t index) { of_[{run, frame}] = index; }
  std::optional<std::size_t> find(const std::string& run, int frame) const;
  const std::string& only_run() const { return of_.begin()->first.first; }

 private:
  std::map<std::pair<std::string, int>, std::size_t> of_;
};

/// The rows of one table that a TableSpec chooses.
class SheetTable {
 public:
  static Expected<SheetTable> make(TableFolder& folder, const TableSpec& spec);

  const std::vector<std::size_t>& rows() const { return rows_; }
  const std::string& name() const { return open_->name; }
  std::string line_of(std::size_t row) const;
  bool has(const std::string& use) const { return spec_->has(use); }
  /// Of a use that is there.
  std::size_t column(const std::string& use) const { return column_of(spec_->columns.at(use)); }
  std::size_t column_of(const std::string& header) const { return open_->table.find(header); }

  const std::string& cell(std::size_t row, std::size_t column) const {
    return open_->table.cell(row, column);
  }
  tl::unexpected<Error> at(std::size_t row, std::size_t column, const std::string& what) const {
    return cells_->at(row, open_->table.header[column], what);
  }
  Expected<double> number(std::size_t row, std::size_t column, const UnitConversion& to_si,
                          bool may_be_missing = false) const;
  Expected<int> whole_number(std::size_t row, std::size_t column) const {
    return cells_->whole_number(row, open_->table.header[column], cell(row, column));
  }
  /// bad_input where the file lacks the column.
  Expected<void> require_column(const std::string& header, const std::string& key) const;

  /// The frame of a row; none where it is another one and those are to be ignored.
  Expected<std::optional<std::size_t>> frame(std::size_t row, const FrameIndex& frames) const;

 private:
  const TableSpec* spec_ = nullptr;
  const OpenTable* open_ = nullptr;
  std::string json_;
  std::shared_ptr<CsvCells> cells_;
  std::vector<std::size_t> rows_;
};

}  // namespace tenter::capture
