// SPDX-License-Identifier: Apache-2.0
#include "common/capture/sheet_import/sheet_tables.h"

#include <algorithm>
#include <filesystem>

#include "common/base/sha256.h"
#include "common/base/text_file.h"
#include "common/capture/csv/csv_import_table.h"

namespace tenter::capture {

TableFolder::TableFolder(const std::string& json_path, std::string main_csv)
    : json_(json_path), main_csv_(std::move(main_csv)) {}

std::string TableFolder::path_of(const std::string& file) const {
  if (file.empty()) return main_csv_;
  const std::filesystem::path beside(main_csv_.empty() ? json_ : main_csv_);
  return (beside.parent_path() / file).string();
}

Expected<const OpenTable*> TableFolder::open(const std::string& file, const CsvOptions& options,
                                             const std::string& key) {
  const std::string path = path_of(file);
  if (path.empty())
    return bad_input(json_ + ": " + key + " names no file, and the import was called without one.");
  std::unique_ptr<OpenTable>& slot =
      open_[{path, options.separator, options.skip_lines, options.skip_rows}];
  if (!slot) {
    const Expected<std::string> text = read_text_file(path, kMaxCsvBytes);
    if (!text) return tl::unexpected(text.error());
    Expected<CsvTable> table = parse_csv(*text, options, path);
    if (!table) return tl::unexpected(table.error());
    slot = std::make_unique<OpenTable>(OpenTable{path, sha256_hex(*text), std::move(*table)});
  }
  return slot.get();
}

std::optional<std::size_t> FrameIndex::find(const std::string& run, int frame) const {
  const auto found = of_.find({run, frame});
  if (found == of_.end()) return std::nullopt;
  return found->second;
}

Expected<SheetTable> SheetTable::make(TableFolder& folder, const TableSpec& spec) {
  SheetTable table;
  table.spec_ = &spec;
  table.json_ = folder.json();
  const auto open = folder.open(spec.file, spec.csv, spec.key);
  if (!open) return tl::unexpected(open.error());
  table.open_ = *open;
  table.cells_ = std::make_shared<CsvCells>(table.open_->table, table.open_->name, folder.json(),
                                            spec.decimal_comma);
  for (const auto& [use, header] : spec.columns)
    if (auto ok = table.require_column(header, spec.key + "." + use); !ok)
      return tl::unexpected(ok.error());
  for (const auto& [header, values] : spec.where)
    if (auto ok = table.require_column(header, "where beside " + spec.key); !ok)
      return tl::unexpected(ok.error());
  for (std::size_t row = 0; row < table.open_->table.row_count(); ++row) {
    const bool keep = std::all_of(spec.where.begin(), spec.where.end(), [&](const auto& condition) {
      const std::string& text = table.cell(row, table.column_of(condition.first));
      return std::find(condition.second.begin(), condition.second.end(), text) !=
             condition.second.end();
    });
    if (keep) table.rows_.push_back(row);
  }
  if (table.rows_.empty())
    return bad_input(table.name() + ": has no rows for " + spec.key + " of " + folder.json() + ".");
  return table;
}

Expected<void> SheetTable::require_column(const std::string& header, const std::string& key) const {
  if (column_of(header) != open_->table.header.size()) return {};
  std::string names;
  for (const std::string& cell : open_->table.header) names += (names.empty() ? "" : ", ") + cell;
  return bad_input(name() + ": has no column \"" + header + "\", which " + json_ + " names at " +
                   key + "; its columns are " + names + ".");
}

std::string SheetTable::line_of(std::size_t row) const {
  return name() + ": line " + std::to_string(open_->table.lines[row]);
}

Expected<double> SheetTable::number(std::size_t row, std::size_t column,
                                    const UnitConversion& to_si, bool may_be_missing) const {
  Expected<double> value =
      cells_->number(row, open_->table.header[column], cell(row, column), may_be_missing);
  if (!value) return value;
  return to_si.apply(*value);
}

Expected<std::optional<std::size_t>> SheetTable::frame(std::size_t row,
                                                       const FrameIndex& frames) const {
  const std::size_t frame_column = column("frame");
  const Expected<int> number = whole_number(row, frame_column);
  if (!number) return tl::unexpected(number.error());
  if (has("run") && !frames.has_runs)
    return at(row, column("run"), "names a run, but " + json_ + " names no runs of the frames");
  if (!has("run") && frames.run_count > 1)
    return at(
        row, frame_column,
        "is a frame of which run? " + spec_->key + " of " + json_ + " names no column \"run\"");
  const std::string& run = has("run") ? cell(row, column("run")) : frames.only_run();
  const std::optional<std::size_t> index = frames.find(run, *number);
  if (!index && !spec_->ignore_other_frames)
    return at(row, frame_column,
              "there is no frame " + std::to_string(*number) +
                  (run.empty() ? "" : " in run " + run) +
                  "; \"other_frames\": \"ignore\" passes over such rows");
  return index;
}

}  // namespace tenter::capture
