// SPDX-License-Identifier: GPL-3.0-or-later
// The captures of a sheet's fit as sequences, with what the report says of them.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "server/estimation/sequences/from_capture.h"
#include "server/jobs/sheet_fit/sheet_options.h"
#include "server/jobs/sheet_fit/sheet_prediction.h"

namespace tenter::jobs {

struct SheetInput {
  std::string id;            ///< SHA-256
  capture::Capture capture;  ///< without its positions, which are in the sequence
  estimation::Role role = estimation::Role::evaluation;
  bool held_out = false;
  estimation::CapturedSequence captured;
  /// The same on a grid of half the spacing, where the grid's error is asked for.
  std::optional<estimation::Sequence> finer;

  const estimation::Sequence& sequence() const { return captured.sequence; }
  /// Frame number as in the capture, of a frame of the sequence.
  int frame_number(std::size_t frame) const { return capture.frame[captured.frame[frame]]; }
};

/// bad_input names the capture and what is wrong with it (from_capture.h).
Expected<std::vector<SheetInput>> sheet_inputs(
    std::vector<std::pair<std::string, capture::Capture>> captures, const SheetFitOptions& options);

/// What a model shows on each of them; cancelled.
Expected<std::vector<Prediction>> predictions(const model::Model& model,
                                              const std::vector<SheetInput>& inputs, int threads,
                                              const std::stop_token& stop);

/// Whether a term lies on edges, where slender cells would be another material (mesh/springs.h).
bool has_springs(const model::Model& model);

}  // namespace tenter::jobs
