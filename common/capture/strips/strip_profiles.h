// SPDX-License-Identifier: Apache-2.0
// The strips of a capture of kind "strip_profiles": strips of one cloth, held at one end and seen
// from the side (thesis 5.3.3).
//
//   spiral       rolled around a cylinder of known radius, then unrolled
//   cantilever   never rolled: bent by its own weight from flat
//
// Such a capture has a run a strip and a frame a point, from the clamp to the free end, and
// channels
//
//   x, y      positions of one point name; gravity points along -y
//   radius    length: of the cylinder; 0, or no such channel: never rolled
//   length    length: from the clamp to the free end along the strip; without it specimen.length
//   sense     other, "1": 1 or -1, to which of its faces the strip was rolled; 0, or no such
//   channel:
//             as the picture shows it, anticlockwise from the clamp on is positive
//
// the last three constant within a run. The specimen's axis_angle is that from the weft to the
// strip's length, its area_density the weight that bends it. Any thread.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

inline constexpr const char* kStripsKind = "strip_profiles";

struct StripProfile {
  double length_m = 0.0;
  double radius_m = 0.0;  ///< 0: never rolled
  int sense = 0;
  std::vector<std::array<double, 2>> points_m;
  std::size_t first_frame = 0;  ///< index
};

/// One a run. bad_input naming the run: fewer than 12 points; a radius, length or sense that is
/// none or changes within a run; a way along the points that is not the length. Also where channels
/// or specimen.area_density are missing. validate() asks here, so that of a capture that was read
/// it cannot fail.
Expected<std::vector<StripProfile>> strip_profiles(const Capture& capture);

/// Standard deviation of one coordinate of a point (m); 0: not known.
double strip_point_sigma(const Capture& capture);

}  // namespace tenter::capture
