// SPDX-License-Identifier: GPL-3.0-or-later
// A knitted specimen of `knit-uniaxial-tracked` (Singal et al. 2024, MIT) between two clamps: five
// pins on the cloth and the force, in five pulls, as one sequence.
//
// All pulls are read at the same clamp distances, so one simulated specimen answers for all of
// them: a frame is a distance, a pull has its own channels. Five pins of pull 0 come first, then
// those of pull 1, ...; forces likewise.
//
// Rest. Before it is taut the cloth sags and curls between the clamps, and does so differently each
// time: pins lie up to 5 mm apart from pull to pull, at full stretch 0.5 mm. So the first frame is
// no place to read the material from. A pin's place in it is first that of a taut distance, mean of
// the fitted pulls, with distances along the pull shrunk to those at rest; knit_places.h mends it.
//
// Readings. The pull went in steps, and what the gauge's screen said was read from a film, with
// jumps: a reading at a distance is on the line through the medians of the nearest on either side.
//
//   auto data = read_knit("acrylic_rib_x.csv", 0.10306, {1, 2, 3});
//   Sequence fitted = data->sequence;   // with what is not to be seen set to NaN
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::bench {

inline constexpr int kPins = 5;
inline constexpr std::array<const char*, kPins> kPinNames = {"right", "left", "bottom", "top",
                                                             "centre"};

inline constexpr std::size_t kTautFrame = 2;  ///< before it the cloth sags here and there

struct KnitData {
  estimation::Sequence sequence;
  int pulls = 0;
  double rest_length_m = 0.0;       ///< between the clamps
  double offset_m = 0.0;            ///< added to what was measured along the pull (knit_places.h)
  std::vector<double> distances_m;  ///< between the clamps, of each frame
};

/// `fitted`: pulls from 0, of which places and standard deviations are taken. bad_input names the
/// file, and a pull that does not reach all distances.
Expected<KnitData> read_knit(const std::string& path, double width_m,
                             const std::vector<int>& fitted);

}  // namespace tenter::bench
