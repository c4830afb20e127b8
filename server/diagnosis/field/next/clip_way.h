// SPDX-License-Identifier: GPL-3.0-or-later
// The way that the clips of a capture went, from its first frame to the farthest, as something that
// can be done again: at other rates, with holds, further.
//
// How far a frame is on it: the largest move, against the first frame, of a handle (the middle of a
// clip, a held node) about the middle of all handles, over their largest distance from it there. Of
// two bars pulled apart that is the strain between them.
//
// Values.
#pragma once

#include <optional>

#include "server/diagnosis/next/experiment.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::diagnosis {

struct ClipWay {
  int farthest = 0;            ///< frame
  double reach = 0.0;          ///< of it
  double fastest_per_s = 0.0;  ///< between neighbouring frames, as durations say
};

/// Nothing where clips do not move (pulled by cords, say), or where there are none.
std::optional<ClipWay> way_of(const estimation::Sequence& sequence);

/// A sheet that was never strained, mounted as in `like` and led through the steps, seen in a few
/// frames of each. Points that the first frame of `like` shows are seen where it saw them, forces
/// and all else read zero: what is seen of a difference does not hang on it.
estimation::Sequence sequence_of(const Experiment& plan, const estimation::Sequence& like,
                                 const ClipWay& way);

}  // namespace tenter::diagnosis
