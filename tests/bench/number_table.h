// SPDX-License-Identifier: GPL-3.0-or-later
// Columns of a CSV as numbers, for benches that read data which are not part of the project.
//
//   auto pulls = read_numbers("acrylic_rib_x.csv", {"run", "frame", "force_N"});
//   const double force_N = (*pulls)[0][2];
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"

namespace tenter::bench {

/// Rows of the columns asked for, in their order. bad_input names file, line and column of what is
/// missing or no number, and a file without rows; else as read_text_file and parse_csv.
Expected<std::vector<std::vector<double>>> read_numbers(const std::string& path,
                                                        const std::vector<std::string>& columns);

}  // namespace tenter::bench
