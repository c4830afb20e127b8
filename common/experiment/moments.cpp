// SPDX-License-Identifier: Apache-2.0
#include "common/experiment/moments.h"

#include <algorithm>

namespace tenter::experiment {

std::optional<std::size_t> frame_at(const frames::FrameSet& run, const std::string& moment) {
  const auto count = static_cast<std::size_t>(run.frame_count());
  if (count == 0) return std::nullopt;
  if (moment == "start") return 0;
  if (moment.empty()) return count - 1;
  for (std::size_t frame = count; frame-- > 0;)
    if (run.phase[frame] >= 0 && run.phases[static_cast<std::size_t>(run.phase[frame])] == moment &&
        run.phase_share[frame] >= 1.0)
      return frame;
  return std::nullopt;
}

std::optional<std::size_t> clip_index(const frames::FrameSet& run, const std::string& id) {
  const auto found = std::find(run.clips.begin(), run.clips.end(), id);
  if (found == run.clips.end()) return std::nullopt;
  return static_cast<std::size_t>(found - run.clips.begin());
}

const frames::StrainSeries* series_of(const frames::FrameSet& run, const std::string& measure) {
  for (const frames::StrainSeries& series : run.strains)
    if (series.measure == measure) return &series;
  return nullptr;
}

const frames::Elements* elements_of(const frames::FrameSet& run, const std::string& kind) {
  for (const frames::Elements& elements : run.elements)
    if (elements.kind == kind) return &elements;
  return nullptr;
}

std::array<double, 3> vector_at(const std::vector<double>& list, std::size_t index) {
  return {list[3 * index], list[3 * index + 1], list[3 * index + 2]};
}

}  // namespace tenter::experiment
