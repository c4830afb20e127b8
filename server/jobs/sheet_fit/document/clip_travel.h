// SPDX-License-Identifier: GPL-3.0-or-later
// How far the clip of a force went, with a sign: what loops of force are drawn over.
//
//   d_k(f) = c_k(f) - c_k(0),   c_k the middle of the material in clip k, in space
//   two clips     travel(f) = (d_k(f) - d_other(f)) . e: how far they went apart
//   otherwise     travel(f) = d_k(f) . e
//
// e is the direction of the largest way, so shear to both sides goes to both sides of zero. Of more
// than two clips, those that are pulled out of the sheet count from where they are least pulled,
// and wait there while others are pulled: such a frame lies below zero, at minus the way of the one
// that went farthest, or else loops would stand on top of each other. A clip that stays in all
// frames has the travel of the one that goes farthest.
//
//   const ClipTravel travel = clip_travel(sequence, clip);
#pragma once

#include <string>
#include <vector>

#include "server/estimation/sequences/sequence.h"

namespace tenter::jobs {

struct ClipTravel {
  std::vector<double> along_m;  ///< one a frame
  std::string words;            ///< what an axis is called: "travel of the clip"
};

/// `clip`: of the sequence's boundaries.
ClipTravel clip_travel(const estimation::Sequence& sequence, std::size_t clip);

}  // namespace tenter::jobs
