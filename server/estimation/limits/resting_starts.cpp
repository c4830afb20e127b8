// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/limits/resting_starts.h"

namespace tenter::estimation {

std::vector<Sequence> started_from_rest(const SequenceEvaluator& evaluator) {
  std::vector<Sequence> all = evaluator.sequences();
  for (std::size_t s = 0; s < all.size(); ++s) {
    for (std::size_t f = 0; f < all[s].frames.size(); ++f) {
      SequenceFrame& frame = all[s].frames[f];
      frame.start = evaluator.states()[s][f];
      const auto& clips = all[s].boundaries[static_cast<std::size_t>(frame.boundary)].clips;
      for (std::size_t c = 0; c < clips.size(); ++c)
        if (clips[c].is_free) frame.clips[c] = frame.start->clips[c];
    }
  }
  return all;
}

}  // namespace tenter::estimation
