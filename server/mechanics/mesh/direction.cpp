// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/mechanics/mesh/direction.h"

#include <cmath>

namespace tenter::mechanics {

namespace {

constexpr double kTangent22_5 = 0.41421356237309504880;  // sqrt(2) - 1

}  // namespace

Direction direction_of(const Eigen::Vector2d& material) {
  const double u = std::abs(material.x());
  const double v = std::abs(material.y());
  if (v < kTangent22_5 * u) return Direction::weft;
  if (u < kTangent22_5 * v) return Direction::warp;
  return Direction::diagonal;
}

}  // namespace tenter::mechanics
