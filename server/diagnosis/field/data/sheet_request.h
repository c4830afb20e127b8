// SPDX-License-Identifier: GPL-3.0-or-later
// What a diagnosis of sheets is asked. Values.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/model/model.h"
#include "server/diagnosis/findings.h"
#include "server/estimation/sequences/sequence.h"
#include "server/estimation/staged/roles.h"

namespace tenter::diagnosis {

struct SheetSequence {
  std::string id;  ///< SHA-256 of the capture
  std::string title;
  estimation::Role role = estimation::Role::evaluation;
  estimation::Sequence sequence;
  bool held_out = false;  ///< no fit sees it; the gain is measured on it
  /// The same measured values on a grid of half the spacing: with it the grid's error is known.
  std::optional<estimation::Sequence> finer = std::nullopt;
  bool is_laid_for_clips = false;  ///< its grid (estimation/sequences/material/grid_layout.h)
  /// Of positions, of all else: the capture states no noise, and the channels' sigmas are a guess
  /// that holds until readings show theirs.
  std::array<bool, 2> has_guessed_noise = {false, false};
};

struct SheetRequest {
  std::vector<SheetSequence> sequences;
  model::Model model;
  Options options;
};

}  // namespace tenter::diagnosis
