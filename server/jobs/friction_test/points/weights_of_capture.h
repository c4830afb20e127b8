// SPDX-License-Identifier: GPL-3.0-or-later
// Weights and lengths of a capture, as the fit of hanging weights takes them: per width and per
// rest length, frame by frame, with the runs and what lies between them.
//
// bad_input where the x stretch was not measured, no x stress is there, a reading is missing, or
// the x axis is neither weft nor warp.
#pragma once

#include <string>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "server/estimation/friction_tests/stretch/weight_table.h"

namespace tenter::jobs {

struct WeightsOfCapture {
  estimation::WeightTable table;  ///< of a cloth of unit width and length
  std::string measure;            ///< green_u or green_v
  double rest_length_m = 0.0;     ///< 0: the capture does not say
};

Expected<WeightsOfCapture> weights_of(const capture::Capture& capture, const std::string& id);

}  // namespace tenter::jobs
