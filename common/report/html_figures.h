// SPDX-License-Identifier: Apache-2.0
// The figures of a result as HTML: loops, residuals and transverse stretches, by capture, with
// their legends.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report {

/// Sections "Loops", "Transverse stretches", "Residuals", "More figures", each only if it has
/// figures.
std::string figure_sections(const Json& result);

}  // namespace tenter::report
