// SPDX-License-Identifier: GPL-3.0-or-later
// How far apart would two fitted models be on an experiment that was not done yet?
//
// With d the difference of what they predict there, in sigmas, J the Jacobian of one of them there
// and H = J0'J0 what the captures at hand know of its parameters, the one that is wrong may still
// give way, at the cost of fitting the old captures worse:
//
//   S = min over dp of |d + J dp|^2 + dp' H dp = d' (I + J H^-1 J')^-1 d
//
// the rise of chi2 that is expected of the wrong model: of the two directions the smaller counts.
#pragma once

#include <optional>

#include "server/diagnosis/next/proposal.h"
#include "server/diagnosis/trials/trial.h"

namespace tenter::diagnosis {

/// Nothing where a model cannot do the experiment. Mounted and measured as curves number `like` of
/// `data`. Corrections that belong to one capture say nothing of a new one. Pure; a few
/// evaluations.
std::optional<Separation> separation(const Experiment& plan, const Reference& one,
                                     const Reference& other, const estimation::DataSet& data,
                                     int like);

}  // namespace tenter::diagnosis
