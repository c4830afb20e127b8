// SPDX-License-Identifier: Apache-2.0
// Private: what two clips that pull a sheet taut say of its rest, and places in the material that
// nobody measured there: a sheet between clamps at rest sags, so that its first picture tells less
// than a taut one.
//
// Places. In a frame in which the clips are as far apart as asked for, a point is seen at p_a by
// one clip and at p_b by the other, both in the material as each clip's grip has it. With e from
// the middle of what one clamps to that of the other, s_a = (p_a - c_a).e and s_b = (c_b - p_b).e:
//
//   t = s_a / (s_a + s_b),   place = c_a + t (c_b - c_a) + across part of (1 - t) p_a + t p_b
//
// as if the sheet were stretched evenly along the pull, its width that of the picture. Mean over
// runs, of each the frame nearest to the distance.
#pragma once

#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "common/capture/sheet_import/sheet_description.h"
#include "common/capture/strict_json.h"

namespace tenter::capture {

/// {"clips": [a, b], "slack_below": length, "read_at": length, "runs": [2, 3]}.
RestSpec read_rest(JsonObject object);

/// Of every vertex. bad_input names what is missing: a clip, its region, a run, or a point that is
/// not seen; and runs whose clips are never nearly so far apart.
Expected<std::vector<Vec2>> places_at_rest(const Capture& capture, const RestSpec& rest);

}  // namespace tenter::capture
