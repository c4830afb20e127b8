// SPDX-License-Identifier: Apache-2.0
// The tables of a sheet fit as HTML, one function per section; each returns "" where the result has
// nothing to show. For the source files of this folder only.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report::sheet {

/// Errors of what was fitted and what was held out, as cards.
std::string error_cards(const Json& result);
/// One row per capture: role, noise, errors before and after, what was dropped.
std::string capture_table(const Json& result);
std::string stage_table(const Json& result);
std::string correlation_table(const Json& result);

}  // namespace tenter::report::sheet
