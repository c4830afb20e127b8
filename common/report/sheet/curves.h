// SPDX-License-Identifier: Apache-2.0
// The fitted curves of a sheet's terms, stress over strain, as HTML figures: 95 % band, starting
// model, and the range of strain that the data reached. For the source files of this folder only.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report::sheet {

/// Section "Curves"; "" where the result has none.
std::string curve_section(const Json& result);

}  // namespace tenter::report::sheet
