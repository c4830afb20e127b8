// SPDX-License-Identifier: GPL-3.0-or-later
// The incremental fit of a cloth model (thesis 3.4.2), a few parameters at a time, so that none of
// them starts far from its place:
//
//   first_guess                constant stiffnesses of all terms from the equation gap (no solves)
//   stretch_u | stretch_v      in parallel, all else as it is
//   shear                      given stretch
//   bend_u | bend_v            in parallel
//   bend_diagonal              from both bending sequences; on request held at what stands in
//                              for it (unseen.h) where these do not tell it
//   shear_again, bend_..again  the same once more from these values, which know of each other
//   coupled                    all curves and sequences together
//
//   std::vector<RoleSequence> measured = {{Role::stretch_u, ...}, {Role::stretch_v, ...}, ...};
//   auto fit = staged_fit(model::preset("cloth_stvk_spline").value(), measured, {});
//   for (const StageRecord& stage : fit->stages) ...       // what each did, and what it left out
//
// A stage that makes things worse for all sequences together (whole_cost.h) is put back, and its
// record says so. Springs between nodes two apart bend and stretch: their stages fit the short
// springs too, to what those were fitted to.
//
// Groups of terms that share a curve (isotropic: weft and warp) are fitted together, to the
// sequences of both. Terms that are none of the six components are fitted in the coupled stage
// only. Sequences for evaluation are not looked at.
//
// Pure. Uses as many threads as it is given, with the same bytes for any number; on_progress is
// called by one of them at a time.
#pragma once

#include "server/estimation/staged/stage.h"

namespace tenter::estimation {

struct StagedResult;

struct StagedOptions {
  StageOptions stage;        ///< its threads are those of the whole fit
  bool repeat = true;        ///< shear and bending once more
  bool coupled = true;       ///< and all together
  bool hold_unseen = false;  ///< diagonal bending that the strips do not tell is held (unseen.h)
  std::optional<double> held_at = {};  ///< at this value; none: at what stands in for it
  /// In the stages before the coupled one, where there is one: frames of a sequence (0: all), and
  /// the least relative fall of the cost (the thesis ends at 1 % of the residual: 0.02). Curves get
  /// their ranges from these frames: too few may miss the largest strains, and the coupled stage
  /// then fits to them a curve that ended before.
  int early_frames = 20;
  double early_tolerance = 1e-2;
  std::vector<std::vector<std::string>> ties;  ///< groups of terms that share a curve
  /// Called with all that was done so far, whenever stages have ended. Such a result (of the same
  /// model, sequences and options) as `resume` is gone on from, and ends in the same bytes: stages
  /// start from parameters alone.
  std::function<void(const StagedResult&)> on_stages_done;
  const StagedResult* resume = nullptr;
};

struct StagedResult {
  model::Model model;
  std::vector<StageRecord> stages;  ///< in the order above
  bool stopped = false;             ///< by on_progress; the model is that of the stages done
};

/// The stages of a model: waves of stages that may be fitted at the same time. `sequences` of each
/// are filled.
std::vector<std::vector<StageTask>> plan_stages(const model::Model& model,
                                                const std::vector<RoleSequence>& measured,
                                                const StagedOptions& options);

/// bad_input as fit_stage(), and where there is nothing to fit to.
Expected<StagedResult> staged_fit(model::Model model, const std::vector<RoleSequence>& measured,
                                  const StagedOptions& options);

}  // namespace tenter::estimation
