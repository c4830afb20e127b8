// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/csv_import.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "common/base/sha256.h"
#include "common/base/text_file.h"
#include "common/capture/csv/branch_detection.h"
#include "common/capture/csv/csv_cells.h"
#include "common/capture/csv/csv_import_table.h"
#include "common/capture/csv/csv_table.h"
#include "common/capture/csv/description.h"
#include "common/capture/csv/finite_measures.h"
#include "common/capture/validate.h"
#include "common/capture/vocabulary.h"

namespace tenter::capture {

namespace {

/// The import of one file, step by step; each step fills one part of the capture.
class Import {
 public:
  Import(const CsvTable& table, const Description& description, const std::string& csv_name,
         const std::string& json_name)
      : table_(table),
        description_(description),
        csv_(csv_name),
        json_(json_name),
        cells_(table, csv_name, json_name, description.decimal_comma) {}

  Expected<ImportedTable> run() {
    capture_ = description_.head;
    if (auto ok = match_columns(); !ok) return tl::unexpected(ok.error());
    if (auto ok = choose_rows(); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_runs(); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_frames(); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_time(); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_channels(); !ok) return tl::unexpected(ok.error());
    if (auto ok = make_stresses_nominal(description_, json_, capture_); !ok)
      return tl::unexpected(ok.error());
    if (auto ok = read_phases(); !ok) return tl::unexpected(ok.error());
    assume_sizes();
    if (auto ok = read_branches(); !ok) return tl::unexpected(ok.error());
    return ImportedTable{std::move(capture_), std::move(rows_)};
  }

 private:
  tl::unexpected<Error> at(std::size_t row, const std::string& column,
                           const std::string& what) const {
    return cells_.at(row, column, what);
  }

  std::size_t column_of(const ColumnDescription& column) const { return table_.find(column.csv); }
  const std::string& cell(std::size_t row, const ColumnDescription& column) const {
    return table_.cell(row, column_of(column));
  }

  /// Every described column is in the file, and every column of the file is described.
  Expected<void> match_columns() const {
    std::set<std::string> known;
    const auto must_be_there = [&](const std::string& name,
                                   const std::string& path) -> Expected<void> {
      known.insert(name);
      if (table_.find(name) != table_.header.size()) return {};
      std::string header;
      for (const std::string& cell : table_.header) header += (header.empty() ? "" : ", ") + cell;
      return bad_input(csv_ + ": has no column \"" + name + "\", which " + json_ + " names at " +
                       path + "; its columns are " + header + ".");
    };
    for (const ColumnDescription& column : description_.columns) {
      if (auto ok = must_be_there(column.csv, "columns"); !ok) return ok;
      if (!column.sigma_column.empty())
        if (auto ok = must_be_there(column.sigma_column, "columns." + column.csv + ".sigma_column");
            !ok)
          return ok;
    }
    for (const auto& [column, values] : description_.where)
      if (auto ok = must_be_there(column, "where"); !ok) return ok;
    if (description_.ignore_other_columns) return {};
    for (const std::string& name : table_.header)
      if (known.count(name) == 0)
        return bad_input(csv_ + ": column \"" + name + "\" is not described in " + json_ +
                         "; describe it, or mark it \"ignore\".");
    return {};
  }

  Expected<void> choose_rows() {
    for (std::size_t row = 0; row < table_.row_count(); ++row) {
      const bool keep = std::all_of(
          description_.where.begin(), description_.where.end(), [&](const auto& condition) {
            const std::string& text = table_.cell(row, table_.find(condition.first));
            return std::find(condition.second.begin(), condition.second.end(), text) !=
                   condition.second.end();
          });
      if (keep) rows_.push_back(row);
    }
    if (description_.rows_repeat_frames) drop_repeated_frames();
    if (!rows_.empty()) return {};
    return bad_input(csv_ + (table_.row_count() == 0 ? ": has a header but no rows."
                                                     : ": no row has the cells that \"where\" of " +
                                                           json_ + " asks for."));
  }

  Expected<double> number(std::size_t row, const std::string& column, const std::string& text,
                          bool may_be_missing) const {
    return cells_.number(row, column, text, may_be_missing);
  }

  Expected<int> whole_number(std::size_t row, const ColumnDescription& column) const {
    return cells_.whole_number(row, column.csv, cell(row, column));
  }

  void drop_repeated_frames() {
    const ColumnDescription* run = description_.find(&ColumnDescription::is_run);
    const ColumnDescription* frame = description_.find(&ColumnDescription::is_frame);
    if (!frame) return;
    std::set<std::pair<std::string, std::string>> seen;
    std::erase_if(rows_, [&](std::size_t row) {
      return !seen.emplace(run ? cell(row, *run) : "", cell(row, *frame)).second;
    });
  }

  /// Runs in the order of the file. A column of texts (paths, say) numbers its runs from 1.
  Expected<void> read_runs() {
    const ColumnDescription* column = description_.find(&ColumnDescription::is_run);
    const ColumnDescription* groups = description_.find(&ColumnDescription::is_group);
    std::map<std::string, int> index_of;
    std::string before;
    bool numbered = column != nullptr;
    for (const std::size_t row : rows_) {
      const std::string key = column ? cell(row, *column) : "1";
      if (key.empty()) return at(row, column->csv, "is blank where the run is named");
      const std::string group = description_.runs_repeat ? "all" : groups ? cell(row, *groups) : "";
      const bool starts = capture_.runs.empty() || key != before;
      if (starts) {
        if (!index_of.emplace(key, static_cast<int>(capture_.runs.size())).second)
          return at(row, column->csv, "run \"" + key + "\" starts again after another run");
        numbered = numbered && whole_number(row, *column).has_value();
        capture_.runs.push_back({static_cast<int>(capture_.runs.size()) + 1, group});
        before = key;
      } else if (capture_.runs.back().group != group) {
        return at(row, groups->csv, "the group changes within run \"" + key + "\"");
      }
      capture_.run.push_back(static_cast<int>(capture_.runs.size()) - 1);
    }
    if (numbered)
      for (const auto& [key, index] : index_of)
        capture_.runs[static_cast<std::size_t>(index)].number = std::stoi(key);
    return {};
  }

  Expected<void> read_frames() {
    const ColumnDescription* column = description_.find(&ColumnDescription::is_frame);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (!column) {
        capture_.frame.push_back(static_cast<int>(i) + 1);
        continue;
      }
      const Expected<int> frame = whole_number(rows_[i], *column);
      if (!frame) return tl::unexpected(frame.error());
      if (i > 0 && capture_.run[i] == capture_.run[i - 1] && *frame <= capture_.frame.back())
        return at(rows_[i], column->csv,
                  "frame " + std::to_string(*frame) + " does not come after frame " +
                      std::to_string(capture_.frame.back()));
      capture_.frame.push_back(*frame);
    }
    return {};
  }

  Expected<void> read_time() {
    const ColumnDescription* column = description_.find(&ColumnDescription::is_time);
    if (!column) return {};
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Expected<double> time = number(rows_[i], column->csv, cell(rows_[i], *column), false);
      if (!time) return tl::unexpected(time.error());
      const double seconds = column->to_si.apply(*time);
      if (i > 0 && capture_.run[i] == capture_.run[i - 1] && seconds <= capture_.time_s.back())
        return at(
            rows_[i], column->csv,
            (seconds < capture_.time_s.back() ? "time goes back within run "
                                              : "time stands still within run ") +
                std::to_string(capture_.runs[static_cast<std::size_t>(capture_.run[i])].number));
      capture_.time_s.push_back(seconds);
    }
    return {};
  }

  /// In the order of the file's columns.
  Expected<void> read_channels() {
    for (const std::string& name : table_.header)
      for (const ColumnDescription& column : description_.columns)
        if (column.is_channel && column.csv == name)
          if (auto ok = read_channel(column); !ok) return ok;
    return {};
  }

  Expected<void> read_channel(const ColumnDescription& column) {
    Channel channel = column.channel;
    const std::size_t index = column_of(column);
    channel.values.reserve(rows_.size());
    for (const std::size_t row : rows_) {
      const Expected<double> value =
          number(row, column.csv, table_.cell(row, index), channel.may_be_missing);
      if (!value) return tl::unexpected(value.error());
      channel.values.push_back(column.to_si.apply(*value));
      if (column.measure != Measure::green || std::isnan(*value)) continue;
      const std::optional<double> strain = engineering_strain(channel.values.back());
      if (!strain) return at(row, column.csv, "a Green strain is above -0.5");
      channel.values.back() = *strain;
    }
    if (!column.sigma_column.empty()) {
      const std::size_t sigma_index = table_.find(column.sigma_column);
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        const bool missing = std::isnan(channel.values[i]);
        const Expected<double> sigma =
            number(rows_[i], column.sigma_column, table_.cell(rows_[i], sigma_index), missing);
        if (!sigma) return tl::unexpected(sigma.error());
        if (*sigma < 0.0)
          return at(rows_[i], column.sigma_column, "a standard deviation cannot be negative");
        channel.sigma_per_frame.push_back(column.to_si.apply_to_difference(*sigma));
      }
    }
    capture_.channels.push_back(std::move(channel));
    return {};
  }

  /// Declared phases by name; undeclared ones are made where the description declares none.
  Expected<void> read_phases() {
    const ColumnDescription* column = description_.find(&ColumnDescription::is_phase);
    std::vector<Phase>& phases = capture_.protocol.phases;
    const bool declared = !phases.empty();
    if (!column) {
      if (phases.size() > 1)
        return bad_input(json_ +
                         ": protocol.phases names several phases, but no column says which "
                         "row belongs to which.");
      if (!declared) phases.push_back({"test", "other", std::nullopt});
      capture_.phase.assign(rows_.size(), 0);
      return {};
    }
    for (const std::size_t row : rows_) {
      const std::string& name = cell(row, *column);
      auto found = std::find_if(phases.begin(), phases.end(),
                                [&](const Phase& phase) { return phase.name == name; });
      if (found == phases.end()) {
        if (declared || name.empty())
          return at(row, column->csv,
                    "phase \"" + name + "\" is not in protocol.phases of " + json_);
        phases.push_back({name, "other", std::nullopt});
        found = std::prev(phases.end());
      }
      capture_.phase.push_back(static_cast<int>(found - phases.begin()));
    }
    return {};
  }

  Expected<void> read_branches() {
    const ColumnDescription* column = description_.find(&ColumnDescription::is_branch);
    if (description_.branch) {
      capture_.branch.assign(rows_.size(), *description_.branch);
      return {};
    }
    if (!column) {
      detect_all_branches();
      return {};
    }
    for (const std::size_t row : rows_) {
      const std::string& text = cell(row, *column);
      const auto translated = column->branch_words.find(text);
      const std::optional<Branch> branch =
          from_word<Branch>(translated == column->branch_words.end() ? text : translated->second);
      if (!branch) return at(row, column->csv, "\"" + text + "\" is not one of " + words<Branch>());
      capture_.branch.push_back(*branch);
    }
    return {};
  }

  void detect_all_branches() {
    for (std::size_t begin = 0; begin < rows_.size();) {
      std::size_t end = begin + 1;
      while (end < rows_.size() && capture_.run[end] == capture_.run[begin]) ++end;
      const std::vector<double> driving = driving_component(capture_, begin, end);
      std::vector<double> time;
      if (!capture_.time_s.empty())
        time.assign(capture_.time_s.begin() + static_cast<std::ptrdiff_t>(begin),
                    capture_.time_s.begin() + static_cast<std::ptrdiff_t>(end));
      const std::vector<Branch> branch = driving.empty()
                                             ? std::vector<Branch>(end - begin, Branch::other)
                                             : detect_branches(driving, time);
      capture_.branch.insert(capture_.branch.end(), branch.begin(), branch.end());
      begin = end;
    }
  }

  void assume_sizes() {
    std::string& notes = capture_.provenance.notes;
    const auto note = [&notes](const std::string& text) {
      notes += (notes.empty() ? "" : " ") + text;
    };
    if (description_.assume_unit_width) {
      capture_.specimen.width_m = 1.0;
      note(
          "The width is not known: 1 m is assumed, so a membrane stress in N/m is the force in N.");
    }
    if (description_.assume_unit_thickness) {
      capture_.specimen.thickness_m = 1e-3;
      note("The thickness is not known: 1 mm is assumed, so 1 kPa counts as 1 N/m.");
    }
  }

  const CsvTable& table_;
  const Description& description_;
  const std::string& csv_;
  const std::string& json_;
  CsvCells cells_;
  std::vector<std::size_t> rows_;
  Capture capture_;
};

}  // namespace

Expected<ImportedTable> import_table(const CsvTable& table, const Description& description,
                                     const std::string& csv_name, const std::string& json_name) {
  return Import(table, description, csv_name, json_name).run();
}

Expected<Capture> import_csv(const std::string& csv_path, const std::string& describe_path) {
  const Expected<Description> description = read_description(describe_path);
  if (!description) return tl::unexpected(description.error());
  const Expected<std::string> text = read_text_file(csv_path, kMaxCsvBytes);
  if (!text) return tl::unexpected(text.error());
  const Expected<CsvTable> table = parse_csv(*text, description->csv, csv_path);
  if (!table) return tl::unexpected(table.error());
  Expected<ImportedTable> imported = import_table(*table, *description, csv_path, describe_path);
  if (!imported) return tl::unexpected(imported.error());
  Expected<Capture> capture = std::move(imported->capture);
  if (!description->origin_given) {
    capture->provenance.imported_from = std::filesystem::path(csv_path).filename().string();
    capture->provenance.imported_sha256 = sha256_hex(*text);
  }
  if (auto ok = validate(*capture); !ok)
    return fail(ok.error().kind,
                csv_path + " with " + describe_path + ": " + ok.error().message + ".");
  return capture;
}

}  // namespace tenter::capture
