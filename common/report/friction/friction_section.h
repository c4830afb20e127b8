// SPDX-License-Identifier: Apache-2.0
// What a test of internal friction found (key friction_test of a result): numbers with intervals,
// words where the data do not tell one. The page's section, the lines of the terminal, and the
// headline of both. Each is "" for a result without the key. For the source files of common/report
// only.
#pragma once

#include <string>

#include "common/report/json_access.h"
#include "common/report/text_report.h"

namespace tenter::report {

/// "Warp: 5 of 5 numbers are told; friction a = 2.22 N/m, b = 3.16 N/m, tau = 0.006."
std::string friction_headline(const Json& result);

/// Section "friction": one table a part.
std::string friction_section(const Json& result);

std::string friction_text(const Json& result, const TextStyle& style);

/// What the errors of a result are shares of, in words: "all stress channels" of most.
std::string measured_words(const Json& result);

}  // namespace tenter::report
