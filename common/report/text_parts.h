// SPDX-License-Identifier: Apache-2.0
// The small parts that the texts of a terminal are made of. What comes in is printable already,
// unless it is a document.
#pragma once

#include <string>

#include "common/report/json_access.h"
#include "common/report/text_report.h"

namespace tenter::report {

inline constexpr const char* kIndent = "                ";  // under the words of a verdict

/// Filled with blanks to a width in columns, at the end or at the beginning.
std::string padded(const std::string& text, std::size_t width);
std::string right(const std::string& text, std::size_t width);

/// Lines that begin with `indent`, each with its line end.
std::string wrapped(const std::string& text, const std::string& indent, int width);

/// With an ANSI code where `on`.
std::string coloured(const std::string& text, const char* code, bool on);

/// The ANSI code of a verdict or of a level of the checklist.
const char* colour_of(const std::string& verdict);

/// Headline and subject, with an empty line below.
std::string title_text(const std::string& headline, const std::string& subject,
                       const TextStyle& style);

/// The interval of a parameter's profile likelihood: "43.1 to 46.8", "above 43.1", "below 46.8" or
/// "no end found".
std::string profile_range(const Json& profile);

/// ERROR and WARNING of the checklist, with an empty line above; "" where all is well.
std::string checklist_text(const Json& result, const TextStyle& style);

}  // namespace tenter::report
