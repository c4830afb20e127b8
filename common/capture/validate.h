// SPDX-License-Identifier: Apache-2.0
// Does a capture in memory make sense? Import, write and read all ask here; nothing else repeats
// the checks.
//
// Checked: all per-frame vectors have one length (at least one frame); names are unique and well
// formed; units are the SI units of their quantities; values are finite where they are not declared
// missing; time and frame numbers increase within a run; runs are in one piece each; sigma is not
// negative; sizes of the specimen are positive; kinematics and stresses name channels and points
// that are there and of a fitting quantity; force channels that carry a stress have a width (y:
// width_y or width) or a cross-section, pascal channels a thickness. How estimation turns these
// into N/m is in README.md, "Stress".
#pragma once

#include "common/base/error.h"
#include "common/capture/capture.h"

namespace tenter::capture {

/// The first defect as one sentence naming channel, run and frame; no file name (the caller knows
/// it).
Expected<void> validate(const Capture& capture);

}  // namespace tenter::capture
