// SPDX-License-Identifier: GPL-3.0-or-later
// Pulls of a specimen that curves were taken of, for design.h. Pure; a few evaluations a plan.
#pragma once

#include "server/diagnosis/next/design.h"

namespace tenter::diagnosis {

/// Nothing where the model cannot do the experiment. Mounted and measured as curves number `like`
/// of `data`. Corrections that belong to one capture say nothing of a new one.
std::optional<Foretold> foretell(const Experiment& plan, const Reference& at,
                                 const estimation::DataSet& data, int like);

/// Refers to its arguments.
Bench curve_bench(const std::vector<const Reference*>& rivals, const estimation::DataSet& data,
                  const RigLimits& limits);

}  // namespace tenter::diagnosis
