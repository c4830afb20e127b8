// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a line in the material runs along the weft, along the warp or between them: which of the
// six curves of thesis 3.3.1 (stretch, shear and bend along weft, warp, diagonal) a spring or a
// hinge belongs to, on regular and irregular meshes alike.
//
// Bins of +-22.5 degrees about each direction, a line having no sense of way; an edge exactly on a
// border is diagonal. Turning the mesh by 90 degrees swaps weft and warp.
#pragma once

#include <Eigen/Core>

namespace tenter::mechanics {

enum class Direction {
  weft,     ///< along u
  warp,     ///< along v
  diagonal  ///< nearer to +45 or -45 degrees than to either
};

/// The direction of a vector (u, v) that is not zero.
Direction direction_of(const Eigen::Vector2d& material);

/// The direction at right angles to one: in which cloth bends over an edge.
constexpr Direction across(Direction along) {
  if (along == Direction::weft) return Direction::warp;
  if (along == Direction::warp) return Direction::weft;
  return Direction::diagonal;
}

}  // namespace tenter::mechanics
