// SPDX-License-Identifier: Apache-2.0
// Private: does the sheet of a capture make sense? A part of validate().
//
// Checked: names; the material (finite; triangles with three different vertices in range, of
// positive area); one position a frame and vertex, finite or declared missing; sigmas not negative;
// clips that clamp a region or vertices, with usable poses of unit quaternions and a mass that is
// not negative; cords of clips that are there, with unit
// directions; supports; gravity. Linear in what there is, up to a sort of names.
#pragma once

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

/// `capture.sheet` is there; frames and runs have been checked.
Expected<void> validate_sheet(const Capture& capture);

}  // namespace tenter::capture
