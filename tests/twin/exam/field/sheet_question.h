// SPDX-License-Identifier: GPL-3.0-or-later
// A sheet of the examination as the diagnosis takes it.
#pragma once

#include "server/diagnosis/field/data/sheet_request.h"
#include "tests/twin/sheets/sheet_generator.h"

namespace tenter::exam {

/// Sequences on the suite's grid with what was read and stated, and the model that the twin is held
/// against: stiffnesses of membranes start where they should not be, those of bending at the truth.
diagnosis::SheetRequest request_of(const twin::SheetTwins& twins);

}  // namespace tenter::exam
