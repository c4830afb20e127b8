// SPDX-License-Identifier: GPL-3.0-or-later
// The strips that captures hold, as the fits of bending take them, with the way back from each to
// its capture and frame.
//
// Captures of one cloth in one direction go together: spirals may come in one and cantilevers in
// another. bad_input that names the capture: no strips in it, a direction that is neither weft nor
// warp, a direction or mass per area that is not that of the first.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "server/estimation/friction_tests/bending/strip_test.h"

namespace tenter::jobs {

struct StripPlace {
  std::size_t capture = 0;
  std::size_t frame = 0;  ///< index of its first one
};

struct StripsOfCaptures {
  estimation::BendingTests tests;  ///< number of a strip: index into places
  std::vector<StripPlace> places;
  std::string measure;  ///< bend_u or bend_v
};

Expected<StripsOfCaptures> strips_of(
    const std::vector<std::pair<std::string, capture::Capture>>& captures);

}  // namespace tenter::jobs
