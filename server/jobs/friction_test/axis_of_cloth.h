// SPDX-License-Identifier: GPL-3.0-or-later
// Which of the cloth's two directions a test's axis lies along.
#pragma once

#include <cmath>
#include <string>

namespace tenter::jobs {

/// "u" (weft) or "v" (warp), to a degree; "" where it is neither.
inline std::string axis_of_cloth(double axis_angle_rad) {
  constexpr double kSlack = 0.0175;
  if (std::abs(std::sin(axis_angle_rad)) < kSlack) return "u";
  if (std::abs(std::cos(axis_angle_rad)) < kSlack) return "v";
  return "";
}

}  // namespace tenter::jobs
