// SPDX-License-Identifier: Apache-2.0
// A capture as CSV plus the description that imports it again, to the same capture and so to the
// same file.
//
//   CsvExport files = export_csv(capture);          // both texts
//   Expected<void> done = write_csv_export(capture, "pull.csv", "pull.json");
//
// Values are SI in their shortest exact form; a missing value is a blank cell.
#pragma once

#include <string>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

struct CsvExport {
  std::string csv;
  std::string description;  ///< JSON
};

CsvExport export_csv(const Capture& capture);

Expected<void> write_csv_export(const Capture& capture, const std::string& csv_path,
                                const std::string& description_path);

}  // namespace tenter::capture
