// SPDX-License-Identifier: GPL-3.0-or-later
// Errors of sheets as a user reads them, and how much better the extended model is on what no fit
// saw: the captures that are held out, else protocols, captures or blocks left out in turn.
#pragma once

#include "server/diagnosis/field/diagnose_sheet.h"
#include "server/diagnosis/verdicts/effect_size.h"

namespace tenter::diagnosis {

/// Relative rms error and R2 of the forces; of the positions about their means over frames where
/// there are no forces. `sequence` < 0: all.
Score score_of_forces(const FieldData& data, const FieldFit& fit, int sequence = -1);

/// The same of residuals that some rows may lack (NaN).
Score score_of_residuals(const FieldData& data, const std::vector<estimation::Row>& rows,
                         const Eigen::VectorXd& residuals, int sequence = -1);

/// How much of the forces (of the motion of points, where forces say nothing) lies between two fits
/// to the same rows (effect_size.h).
SizeInterval sheet_effect_size(const FieldData& data, const FieldFit& without, const FieldFit& with,
                               unsigned long long seed);

/// Fills the scores of baseline and extended model, in sample and on what no fit saw.
void measure_sheet_gain(SheetDiagnosis& d, const SheetRequest& request, const Control& control);

}  // namespace tenter::diagnosis
