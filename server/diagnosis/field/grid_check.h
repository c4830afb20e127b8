// SPDX-License-Identifier: GPL-3.0-or-later
// Is it the grid? Before any material is blamed for what a model misses on sheets, the same
// protocols are solved on grids of half the spacing, and what the grid alone is wrong by is taken
// off (estimation/sequences/discretisation).
//
//   if (auto ok = check_grid(request, control, d); !ok) return tl::unexpected(ok.error());
//
// Where that takes most of what the baseline missed of forces beyond the noise (positions keep the
// grid's error, which says nothing where sheets fold), the verdict is NUMERICAL mesh_resolution.
// Either way the chain goes on with readings without the grid's error, and what it took off says
// how small an effect may be that is only what the estimate of it misses (`taken_by_grid`).
// Sequences that come without a finer grid stay as they are; where nothing is missed nothing is
// asked. A grid that comes to no rest is said in the checklist. Cost: every frame at rest on the
// finer grid, a fit.
#pragma once

#include "server/diagnosis/field/diagnose_sheet.h"

namespace tenter::diagnosis {

/// Changes data and baseline; adds to verdicts and checklist. Errors: cancelled.
Expected<void> check_grid(const SheetRequest& request, const Control& control, SheetDiagnosis& d);

}  // namespace tenter::diagnosis
