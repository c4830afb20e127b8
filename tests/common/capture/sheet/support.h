// SPDX-License-Identifier: Apache-2.0
// Captures of a deforming sheet that tests share.
#pragma once

#include "common/capture/capture.h"

namespace tenter::capture::test {

/// Two runs of two frames of a square of 3 x 3 vertices: an imposed clip on a region, a free one on
/// vertices, two cords, a table, vertices and tensions that were not seen.
Capture small_sheet_capture();

/// A rippled square of side x side vertices between two clips over `frames` frames.
Capture rippled_sheet_capture(int side, int frames);

}  // namespace tenter::capture::test
