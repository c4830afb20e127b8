// SPDX-License-Identifier: GPL-3.0-or-later
// Which effects could explain what a fit to sheets left over? The whole catalogue at once, without
// a refit (screening/ has the statistics).
//
//   columns    added_columns(): derivatives by what is off, through the equilibrium's factor
//   noise      white, one sigma a row, drawn in the coordinates that the columns span
//   lack of fit   the largest, over kinds of channels of a sequence, of chi2 over what noise
//   exceeds
//                 there once in twenty captures
//
// Cost: one factorisation a frame, a solve and a look at every element for each column, and a
// product of rows by the square of columns.
#pragma once

#include "server/diagnosis/field/data/field_fit.h"
#include "server/diagnosis/screening/candidate.h"

namespace tenter::diagnosis {

/// Errors as added_columns().
Expected<Screen> screen_field(const FieldFit& fit, const FieldData& data,
                              const Excitation& excitation, const ScreenOptions& options,
                              int threads);

/// What noise of one sigma a row leaves after so many free parameters.
double expected_chi2(const FieldFit& fit);

}  // namespace tenter::diagnosis
