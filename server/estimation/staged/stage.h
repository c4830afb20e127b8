// SPDX-License-Identifier: GPL-3.0-or-later
// One stage of a staged fit (thesis 3.4.2): some curves fitted to some sequences, all else held.
//
//   1. stiffness splines begin with one control point, over the strains that the measured sequences
//      reach without outliers
//   2. a first guess from the equation gap, where its cost is the lower one
//   3. frames that have no rest are left out, and named
//   4. output-error fit; a point more; until neither one nor two points more let (3.6) fall by 1 %,
//      there are enough, or what is left is noise
//
//   auto record = fit_stage(model, {"stretch_u", {"weft"}, {}, sequences}, options);
//
// Pure: the callback is called from the calling thread; the same bytes for any number of threads.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/estimation/sequences/sequence_evaluator.h"
#include "server/estimation/staged/roles.h"

namespace tenter::estimation {

struct StageProgress {
  std::string stage;
  int control_points = 0;
  int iteration = 0;
  double cost = 0.0;
};

/// A frame that is about to be solved, with the parameters that are tried.
struct StageFrame {
  const std::string& stage;
  const model::Model& model;  ///< whose terms name the parameters; its values are the start's
  FrameNote at;
};

struct StageOptions {
  int threads = 1;
  Channels channels = Channels::thesis;
  Weighting weighting = {};  ///< of rows in (3.6), where a stage has several sequences
  int most_frames = 0;       ///< of a sequence, evenly over it; 0: all, as of models that remember
  int most_points = 5;
  bool knots_from_data = false;  ///< where the residual asks for them (splines/knot_choice.h); even
  double least_gain = 0.01;      ///< of (3.6), for one control point more
  bool stop_at_noise = true;     ///< no point more where the rows' sigmas explain what is left of
                                 ///< (3.6), to two of its standard deviations
  double outliers = 0.005;       ///< share of the area at each end of the strains
  bool first_guess = true;       ///< by the equation gap
  GapOptions gap;
  FitMethod method = FitMethod::bounded_marquardt;
  int max_iterations = 30;    ///< of each fit
  double tolerance = 1e-3;    ///< relative fall of the cost
  double tolerance_N = 1e-7;  ///< of the net force of a frame at rest
  RobustLoss loss = {};
  std::function<void(const StageFrame&)> on_frame;        ///< from any thread; returns soon
  std::function<bool(const StageProgress&)> on_progress;  ///< returns false to stop
};

struct StageTask {
  std::string name;
  std::vector<std::string> terms;              ///< ids of those that are fitted
  std::vector<std::vector<std::string>> ties;  ///< groups with one curve each
  std::vector<RoleSequence> sequences;
  /// Fitted too, with the control points that they have: terms of an earlier stage that pull where
  /// these do.
  std::vector<std::string> along = {};
  bool guess = true;  ///< by the equation gap; else from what is there
  /// Where the sequences do not tell the terms, diagonal bending, these are held at what stands in
  /// for them, here and in later stages (unseen.h).
  bool holds_unseen = false;
  std::optional<double> held_at = {};  ///< or at this value
  bool refine = true;                  ///< splines get more control points; else as they are
  bool from_one_point = true;  ///< refinement begins with constant stiffness; else with what is
                               ///< there
};

/// What a stage did; nothing is left out of it.
struct StageRecord {
  std::string name;
  std::string message;     ///< how it ended; why it was skipped
  bool done = false;       ///< its values are in the model
  bool converged = false;  ///< the fit that they are from
  bool stopped = false;
  bool held = false;           ///< what the stage was for is not seen by its sequences
  bool guessed = false;        ///< the equation gap's guess was the better start
  std::string guess_message;   ///< why there was none
  double cost_at_start = 0.0;  ///< with the values that the stage was given
  double cost_before = 0.0;    ///< where the first fit started
  double cost_after = 0.0;
  int rows = 0;
  int iterations = 0;
  struct Refinement {
    int control_points = 0;
    double cost = 0.0;
    bool kept = false;
  };
  std::vector<Refinement> refinements;
  struct Dropped {
    std::string sequence;
    int frame = 0;  ///< from 1
    std::string reason;
  };
  std::vector<Dropped> dropped;
  struct Named {
    std::string parameter;  ///< "term.parameter"
    ParameterState state;
  };
  std::vector<Named> not_free;  ///< fitted, but at a bound, flat or without gradient
};

/// Writes values, errors, control points and ranges into `model`. bad_input as tie_terms() and
/// SequenceEvaluator::make(); a stage that could not be done is no error but a record that says so,
/// and leaves the model as it was.
Expected<StageRecord> fit_stage(model::Model& model, const StageTask& task,
                                const StageOptions& options);

}  // namespace tenter::estimation
