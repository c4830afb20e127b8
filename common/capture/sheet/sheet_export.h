// SPDX-License-Identifier: Apache-2.0
// A capture of a sheet as CSV tables, the description that imports them again, to the same capture
// and so to the same file, and its mesh at rest as OBJ for other programs.
//
//   auto written = export_sheet(capture, "pull.json");    // pull_positions.csv, pull.obj, ...
//
// Values are SI in their shortest exact form; what is missing is a blank cell.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

struct ExportedFile {
  std::string name;  ///< without a folder
  std::string text;
};

/// The description first. `stem` begins the names of all.
std::vector<ExportedFile> sheet_files(const Capture& capture, const std::string& stem);

/// Writes them beside `describe_path`, which is the name of the description; returns their paths.
/// Where files are there already and `replace` is false: refused, and nothing is written.
Expected<std::vector<std::string>> export_sheet(const Capture& capture,
                                                const std::string& describe_path,
                                                bool replace = false);

}  // namespace tenter::capture
