// SPDX-License-Identifier: Apache-2.0
// Load, unload or hold of every frame of one run, where the file does not say.
//
// `driving` is what the test moves (a stretch, length, displacement or shear). load: it rises;
// unload: it falls; hold: it stays within a band for so long that, moving as it usually does, it
// would have crossed the band thirty times. The band is the larger of 1 % of the run's range and
// six times the noise (the noise from second differences, robustly), at most a tenth of the range.
// A turning point counts once the signal has come back by a band; the frames from the extreme on
// belong to the new branch. A run that does not move is one hold. Without times the frame number
// stands for time.
#pragma once

#include <vector>

#include "common/capture/capture.h"

namespace tenter::capture {

/// `time` is empty or as long as `driving`; all values finite.
std::vector<Branch> detect_branches(const std::vector<double>& driving,
                                    const std::vector<double>& time);

/// Of the prescribed components (of the observed ones, where none is prescribed) the one that moves
/// most in frames [begin, end); missing readings repeat the last one. Empty where nothing is
/// measured.
std::vector<double> driving_component(const Capture& capture, std::size_t begin, std::size_t end);

}  // namespace tenter::capture
