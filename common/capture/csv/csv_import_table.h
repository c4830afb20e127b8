// SPDX-License-Identifier: Apache-2.0
// Private: the import of a table that has been read already, for descriptions of several tables.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "common/capture/csv/csv_table.h"
#include "common/capture/csv/description.h"

namespace tenter::capture {

inline constexpr std::size_t kMaxCsvBytes = 2000000000;

struct ImportedTable {
  Capture capture;                ///< not validated
  std::vector<std::size_t> rows;  ///< of the table: one a frame
};

Expected<ImportedTable> import_table(const CsvTable& table, const Description& description,
                                     const std::string& csv_name, const std::string& json_name);

}  // namespace tenter::capture
