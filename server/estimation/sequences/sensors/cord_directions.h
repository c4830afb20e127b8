// SPDX-License-Identifier: GPL-3.0-or-later
// In which directions do the cords of a clip measure its force?
//
// At right angles to each other: along the first cord, along what the next one adds to that, and so
// on. Directions are means over frames, in space, or in the clip's frame where they vary less
// there.
//
//   const CordDirections known = cord_directions(sheet, clip, frames);
//   for (const auto& [cord, direction] : known.along) ...       // the cord that adds it
//
// Pure; linear in cords x frames.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/sheet/sheet.h"

namespace tenter::estimation {

struct CordDirections {
  std::vector<std::pair<std::string, Eigen::Vector3d>> along;  ///< cord and unit vector
  bool turns_with_clip = false;                                ///< they are of the clip's frame
};

/// `frames`: some of the capture's, at least one.
CordDirections cord_directions(const capture::Sheet& sheet, const capture::ClipTrack& clip,
                               const std::vector<std::size_t>& frames);

}  // namespace tenter::estimation
