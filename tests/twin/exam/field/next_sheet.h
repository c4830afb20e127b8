// SPDX-License-Identifier: GPL-3.0-or-later
// The rig of the examination: leads a twin's sheet as a verdict proposes.
#pragma once

#include <optional>

#include "server/diagnosis/next/proposal.h"
#include "tests/twin/sheets/sheet_suite.h"

namespace tenter::exam {

/// The proposed way, planned frame by frame in the mounting of that plan of the suite; nothing
/// where the suite has none of that name.
std::optional<twin::SheetPlan> planned(const diagnosis::Design& design,
                                       const twin::SheetSuite& suite);

}  // namespace tenter::exam
