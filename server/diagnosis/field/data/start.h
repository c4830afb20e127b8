// SPDX-License-Identifier: GPL-3.0-or-later
// Where the first fit to sheets begins, and what it may not move from there. Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/field/data/field_fit.h"
#include "server/diagnosis/findings.h"

namespace tenter::diagnosis {

/// The model after a joint stage of the staged fit (its start is the equation gap's where that is
/// the better one), with bending bounded and no stiffness where nothing is. Where the stage leads
/// nowhere: from stiffnesses that foretell forces as large as those measured. Frames that have no
/// rest are taken out of `data` and named in `dropped`. bad_input as the stage.
Expected<model::Model> find_start(const model::Model& start, const Control& control,
                                  FieldData& data, std::vector<std::string>& dropped);

/// The model with its membrane as stiff, all alike, as forces ask for, and bending bounded; nothing
/// where it has no rest or no force is known.
std::optional<model::Model> scaled_to_forces(const model::Model& start, const FieldData& data);

/// Stiffnesses that the captures do not determine and that ran away: a sheet that resists nothing
/// in shear, or everything, comes to no rest in the next fit. Usual is the start value times what
/// the fit made of those that it determined; who fell far below is held there, who rose far above
/// is bounded, and whoever stayed may move by a factor from there on, or not at all where nothing
/// shows it: what is foretold of other captures would hang on where a refit happened to leave it.
/// `jacobian` of the fit; none, where that failed: then whoever ran away is held. Names of those
/// that ran.
std::vector<std::string> hold_undetermined(const model::Model& start,
                                           const estimation::RowMatrix* jacobian,
                                           model::Model& held);

}  // namespace tenter::diagnosis
