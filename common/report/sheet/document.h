// SPDX-License-Identifier: Apache-2.0
// What a fit to sequences of a sheet says in short, and how its errors read: the same words in the
// page and on the terminal. The keys are in README.md. For the source files of this folder only.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report::sheet {

/// "The fit misses forces by 12 mN (4.0 sigma) and positions by 0.081 mm (1.1 sigma)."
std::string headline(const Json& result);

/// "Fit of 5 captures with cloth_stvk; 2 more held out".
std::string subject(const Json& result);

/// "12.3 mN", "0.081 mm": `unit` is "N" or "m".
std::string quantity(std::optional<double> value, const char* unit);

/// "4.0 sigma" with the Greek letter; an en dash where there is none.
std::string sigmas(std::optional<double> value);

/// "0.41 mm -> 0.081 mm" of an errors object; an en dash where there is none.
std::string change(const Json& errors, const char* unit, const std::string& arrow);

}  // namespace tenter::report::sheet
