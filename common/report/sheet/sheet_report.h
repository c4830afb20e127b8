// SPDX-License-Identifier: Apache-2.0
// A fit to sequences of a sheet (schema "tenter.sheet_fit") as one HTML page and as text. Called by
// render_html and render_text, which are the door.
#pragma once

#include <string>

#include "common/report/json_access.h"
#include "common/report/text_report.h"

namespace tenter::report::sheet {

inline constexpr const char* kSchema = "tenter.sheet_fit";

/// `result` has been read by parse_result.
std::string render_page(const Json& result);
std::string render_words(const Json& result, const TextStyle& style);

}  // namespace tenter::report::sheet
