// SPDX-License-Identifier: GPL-3.0-or-later
// Where something last moved to, frame by frame: what the friction of a cord depends on.
//
//   +1 where `travel` last grew, -1 where it last fell, 0 before it first moved
//
// What is below a hundredth of its range is no turn, and a turn is dated to where the travel left
// its extreme for good: by more than its own noise, which its second differences show. Where it
// turned between two frames, the larger of them belongs to the way that it lies on.
//
// Pure; linear in the frames.
#pragma once

#include <vector>

namespace tenter::estimation {

/// `starts`: frames that begin anew (none: the first alone). All zero where the whole range is
/// below `least_range`.
std::vector<double> last_motions(const std::vector<double>& travel, const std::vector<bool>& starts,
                                 double least_range);

}  // namespace tenter::estimation
