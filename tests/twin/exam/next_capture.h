// SPDX-License-Identifier: GPL-3.0-or-later
// The rig of the examination: does to the twin's cloth what a verdict proposes.
#pragma once

#include <optional>
#include <vector>

#include "server/diagnosis/next/design.h"
#include "tests/twin/suite.h"

namespace tenter::exam {

/// The proposed pull, planned frame by frame in the mounting of that capture of the suite; nothing
/// where the suite has no such capture.
std::optional<twin::PlannedCapture> planned(const diagnosis::Design& design,
                                            const std::vector<twin::PlannedCapture>& suite);

}  // namespace tenter::exam
