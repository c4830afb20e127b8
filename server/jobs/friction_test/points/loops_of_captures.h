// SPDX-License-Identifier: GPL-3.0-or-later
// The loops of one strain that captures hold, as the fit of loops takes them.
//
// Of every capture the runs in which weft or warp alone is strained: the stretch along it was
// measured and goes to and fro, and the other one is not held to anything else (free, observed, or
// still within 2 % of the range). Loads are nominal stresses (N/m). At most 60 readings a branch,
// each the mean of its neighbours (estimation::thin).
//
// bad_input that says what is missing: no such run, or loops along both where `direction` does not
// say which.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/capture/capture.h"
#include "server/estimation/friction_tests/loops/loop_table.h"

namespace tenter::jobs {

struct LoopsOfCaptures {
  estimation::LoopTable table;
  std::string measure;  ///< green_u or green_v
  /// The same readings as captures of their own: those runs alone, and no other stress.
  std::vector<std::pair<std::string, capture::Capture>> captures;
  int runs = 0;
  int runs_passed_over = 0;
};

/// `direction`: "weft", "warp", or "" for the one that has loops.
Expected<LoopsOfCaptures> loops_of(
    const std::vector<std::pair<std::string, capture::Capture>>& captures,
    const std::string& direction);

}  // namespace tenter::jobs
