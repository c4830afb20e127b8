// SPDX-License-Identifier: Apache-2.0
// A deformed sheet as an inline SVG picture: seen along its narrowest axis, triangles coloured by
// the residual, arrows from model to measurement five times their length (as in thesis Fig. 3.6).
//
//   std::string svg = mesh_svg(mesh);   // an entry of "meshes"; "" if it has no triangle to show
//
// Triangles are drawn from back to front, so folds lie over each other as they do. For the source
// files of this folder only.
#pragma once

#include <string>

#include "common/report/json_access.h"

namespace tenter::report::sheet {

inline constexpr double kArrowScale = 5.0;

std::string mesh_svg(const Json& mesh);

/// Section "Sheets": every mesh of the result with its capture above it; "" where there is none.
std::string mesh_section(const Json& result);

}  // namespace tenter::report::sheet
