// SPDX-License-Identifier: GPL-3.0-or-later
// Errors of sheets as a user reads them, and how much better the extended model is on what no fit
// saw: the captures that are held out, else protocols, captures or blocks left out in turn.
#pragma once

#include "server/diagnosis/field/diagnose_sheet.h"

namespace tenter::diagnosis {

/// Relative rms error and R2 of the forces; of the positions about their means over frames where
/// there are no forces. `sequence` < 0: all.
Score score_of_forces(const FieldData& data, const FieldFit& fit, int sequence = -1);

/// The same of residuals that some rows may lack (NaN).
Score score_of_residuals(const FieldData& data, const std::vector<estimation::Row>& rows,
                         const Eigen::VectorXd& residuals, int sequence = -1);

/// Share of the forces (of the motion of points, where forces say nothing) that lies between two
/// fits, rms over rms, with a 95 % interval over resampled blocks.
struct FieldSize {
  bool of_force = true;
  double size = 0.0, lo = 0.0, hi = 0.0;
};
FieldSize size_between(const FieldData& data, const std::vector<estimation::Row>& rows,
                       const Eigen::VectorXd& without, const Eigen::VectorXd& with, int blocks,
                       unsigned long long seed);

/// Fills the scores of baseline and extended model, in sample and on what no fit saw.
void measure_sheet_gain(SheetDiagnosis& d, const SheetRequest& request, const Control& control);

}  // namespace tenter::diagnosis
