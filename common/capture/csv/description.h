// SPDX-License-Identifier: Apache-2.0
// What the JSON beside a CSV says: which column is what, and the capture's head. README.md
// documents the keys; describe.schema.json is the same for editors.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "common/capture/csv/csv_table.h"
#include "common/capture/units.h"

namespace tenter::capture {

/// What the numbers of a strain or stress column are: what captures hold, or a measure of finite
/// strain that the import turns into it (finite_measures.h).
enum class Measure { held, green, second_piola };

/// One column of the CSV. A text column may serve as run, group and phase at once.
struct ColumnDescription {
  std::string csv;  ///< the header cell
  bool is_channel = false;
  bool is_time = false;
  bool is_frame = false;
  bool is_run = false;
  bool is_group = false;
  bool is_phase = false;
  bool is_branch = false;
  bool is_ignored = false;
  Channel channel;       ///< everything but the values; sigma and resolution are SI already
  UnitConversion to_si;  ///< channel and time columns
  Measure measure = Measure::held;
  std::string sigma_column;  ///< header cell of the column with one sigma per row, in the same unit
  std::map<std::string, std::string>
      branch_words;  ///< the file's words for load, unload, hold, other
};

struct Description {
  CsvOptions csv;
  bool decimal_comma = false;
  bool ignore_other_columns = false;
  std::vector<std::pair<std::string, std::vector<std::string>>>
      where;  ///< keep rows with these cells
  std::vector<ColumnDescription> columns;
  std::optional<Branch> branch;        ///< all rows, where the description says so
  bool rows_repeat_frames = false;     ///< of rows with the same run and frame the first one counts
  bool origin_given = false;           ///< provenance names the imported file itself
  bool runs_repeat = false;            ///< all runs are one group
  bool assume_unit_width = false;      ///< 1 m
  bool assume_unit_thickness = false;  ///< 1 mm
  Capture head;                        ///< no frames, runs or channels; phases as declared

  const ColumnDescription* find(bool ColumnDescription::*use) const;
};

/// Reads and checks the JSON on its own. Errors name the file and the path of the bad key.
Expected<Description> read_description(const std::string& path);
Expected<Description> parse_description(const std::string& text, const std::string& name);

}  // namespace tenter::capture
