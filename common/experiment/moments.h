// SPDX-License-Identifier: Apache-2.0
// Where in the frames of a run a moment, a clip or a strain of its scene is.
//
//   std::optional<std::size_t> frame = frame_at(run, "settle");   // the last of that phase
//   const frames::StrainSeries* bend = series_of(run, "bend_u");
//
// Pure; any thread; linear in the frames.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "common/frames/frames.h"

namespace tenter::experiment {

/// Last frame of the phase; "start" is frame 0, "" the last frame. None where the run ended before.
std::optional<std::size_t> frame_at(const frames::FrameSet& run, const std::string& moment);

std::optional<std::size_t> clip_index(const frames::FrameSet& run, const std::string& id);

/// The strains of the first term with this measure; null where no term has it.
const frames::StrainSeries* series_of(const frames::FrameSet& run, const std::string& measure);

const frames::Elements* elements_of(const frames::FrameSet& run, const std::string& kind);

/// Number `index` of a list of vectors.
std::array<double, 3> vector_at(const std::vector<double>& list, std::size_t index);

}  // namespace tenter::experiment
