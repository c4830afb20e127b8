// SPDX-License-Identifier: GPL-3.0-or-later
// Fewer frames, so that fits cost less: means over pieces of blocks.
#pragma once

#include <vector>

#include "server/estimation/curves.h"

namespace tenter::estimation {

/// At most `max_frames` frames a block, each the mean of its neighbours; readings that are left out
/// (same layout as the channels) and frames that have no other are left out of the means. Blocks,
/// runs and time are kept.
Curves thin(const Curves& curves, int max_frames, const std::vector<std::vector<bool>>& left_out);

}  // namespace tenter::estimation
