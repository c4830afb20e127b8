// SPDX-License-Identifier: GPL-3.0-or-later
// How many elements are worked on at once.
#pragma once

namespace tenter::mechanics {

constexpr int kLanes = 8;   ///< elements in one vector of the kernels (lanes.h)
constexpr int kChunk = 64;  ///< elements per call of measures and laws

}  // namespace tenter::mechanics
