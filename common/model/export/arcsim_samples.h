// SPDX-License-Identifier: Apache-2.0
// The strains at which an ARCSim material has its samples (arcsim.h), shared by writing and
// reading.
#pragma once

#include <array>
#include <cmath>

namespace tenter::model::arcsim {

inline constexpr int kStretching = 6;
inline constexpr int kBending = 5;
inline constexpr double kLargestStretch = 7.0 / 6.0;
/// Green strain along the pull at the largest stretch, 13/72.
inline constexpr double kGreen = 0.5 * (kLargestStretch * kLargestStretch - 1.0);
inline constexpr double kCurvature_per_m = 30.0;  ///< between columns of the bending table
inline constexpr double kBendingFactor = 12.0;    ///< its stiffness over ours

/// Green strains of a row: along weft and warp, and w_u . w_v.
struct Strains {
  double u = 0.0, v = 0.0, uv = 0.0;
};
inline Strains strains_of(double stretch, double angle_rad) {
  const double green = 0.5 * (stretch * stretch - 1.0);
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {green * c * c, green * s * s, 2.0 * green * s * c};
}
/// The pull of rows 1 to 5; row 0 is at rest.
inline Strains strains_of_row(int row) {
  // exact zeros and equal squares on the axes and the diagonal, which sines do not give
  static constexpr double kRoot = 0.35355339059327376220;  // sqrt(2)/4
  static constexpr std::array<double, 5> kCosine2 = {1.0, 0.5 + kRoot, 0.5, 0.5 - kRoot, 0.0};
  static constexpr std::array<double, 5> kSine = {0.0, 2.0 * kRoot, 1.0, 2.0 * kRoot, 0.0};
  if (row == 0) return {};
  const double c2 = kCosine2[static_cast<std::size_t>(row - 1)];
  return {kGreen * c2, kGreen * (1.0 - c2), kGreen * kSine[static_cast<std::size_t>(row - 1)]};
}

}  // namespace tenter::model::arcsim
