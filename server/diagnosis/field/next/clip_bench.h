// SPDX-License-Identifier: GPL-3.0-or-later
// Ways that clips may lead a sheet next, for next/design.h. Pure; a plan costs every rival its
// frames' rests with their sensitivities.
#pragma once

#include "server/diagnosis/field/data/field_fit.h"
#include "server/diagnosis/next/design.h"

namespace tenter::diagnosis {

/// Nothing where the model finds no rest on the way. Corrections that belong to one capture say
/// nothing of a new one.
std::optional<Foretold> foretell(const Experiment& plan, const FieldFit& at, const FieldData& data,
                                 int like, int threads);

/// In the mountings in which the rivals differ most on what was captured. Refers to its arguments.
Bench clip_bench(const std::vector<const FieldFit*>& rivals, const FieldData& data,
                 const RigLimits& limits, int threads);

}  // namespace tenter::diagnosis
