// SPDX-License-Identifier: GPL-3.0-or-later
// Which pull would tell two causes apart that the captures at hand cannot? Of a family of pulls
// (loops at two rates, holds, nested loops, returns, offsets, repeats, a wider range), in every
// mounting that the captures show, the one within the rig's limits where the models of the causes
// are expected to be farthest apart.
//
//   if (auto best = design_next({&with_friction, &with_viscosity}, *data, {}))
//     words_of(best->plan), best->separation.of_noise()
//
// Evidence counts by branches, not by samples: S over its readings, times the branches.
#pragma once

#include <optional>
#include <vector>

#include "server/diagnosis/next/proposal.h"
#include "server/diagnosis/trials/trial.h"

namespace tenter::diagnosis {

/// Whether what shall be told apart is a question of rates, which only a second rate or a hold
/// answers, however far apart two fitted models may be otherwise.
enum class Question { any, of_rate };

/// Nothing where no pull within the limits would bring them half a sigma apart (rms).
std::optional<Design> design_next(const std::vector<const Reference*>& rivals,
                                  const estimation::DataSet& data, const RigLimits& limits,
                                  Question question = Question::any);

}  // namespace tenter::diagnosis
