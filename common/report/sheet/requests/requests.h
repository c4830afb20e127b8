// SPDX-License-Identifier: Apache-2.0
// What a sheet's fit was asked for beside its stages, as HTML sections and as lines of text; each
// "" where the result has none. For the source files of `common/report/sheet` only.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report::sheet {

/// How large the error of each capture's grid is that was taken off.
std::string grid_error_section(const Json& result);
/// The waterfall: costs of all starts in their order.
std::string start_section(const Json& result);
std::string convexity_section(const Json& result);
/// Which material samples were tried, where, and what held-out captures gained.
std::string sample_section(const Json& result);
std::string limit_section(const Json& result);

/// All of them on the terminal, a line each.
std::string request_lines(const Json& result);

}  // namespace tenter::report::sheet
