// SPDX-License-Identifier: GPL-3.0-or-later
// What do sheets excite? The strains that the fitted frames reach, element by element, and the mean
// strain of each frame as the path that a material point would have taken: it says whether they are
// unloaded, loaded again, held, and how fast.
//
//   const Excitation e = examine_sheets(data, baseline.states);     // then any effect's variants
//
// Pure; cost is that of the strains of every frame.
#pragma once

#include "server/diagnosis/effect.h"
#include "server/diagnosis/field/data/field_fit.h"

namespace tenter::diagnosis {

/// bad_input as MeshModel::make.
Expected<Excitation> examine_sheets(const FieldData& data, const FieldStates& states);

/// Gives spline laws of the model that have no range yet the strains that were reached.
void adapt_ranges(model::Model& model, const Excitation& excitation);

}  // namespace tenter::diagnosis
