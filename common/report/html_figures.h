// SPDX-License-Identifier: Apache-2.0
// The figures of a result as HTML: loops, residuals and transverse stretches, by capture, with
// their legends.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report {

/// How the legend names the two models of the figures, those of role "baseline" and "extended".
struct ModelWords {
  std::string baseline;  ///< "baseline model"
  std::string extended;  ///< "extended model"
  bool are_two = true;   ///< else the baseline is "model" and the other is not drawn
};

/// Sections "Loops", "Transverse stretches", "Residuals", "More figures", each only if it has
/// figures.
std::string figure_sections(const Json& result, const ModelWords& models);

}  // namespace tenter::report
