// SPDX-License-Identifier: GPL-3.0-or-later
// Curves fitted on a grid make up for the grid's error: they are those that this grid shows the
// measured values with, and another grid, or the cloth, has others. Which are the cloth's?
//
//   e = e(curves)        the grid's error, from a second grid (sequences/discretisation)
//   curves = fit(measured - e)                     all terms and fitted sequences together
//
// in turn, until e changes by less than `settled_sigmas` standard deviations of a reading (root
// mean square over all fitted sequences), or `most_rounds` were done.
//
// How many control points a curve has was chosen with the grid's error in sight: where a start is
// given, the first round is the whole staged fit once more from there.
//
//   auto fit = grid_free_fit(staged->model, on_two_grids, {.stage = options.stage});
//   if (!fit) return tl::unexpected(fit.error());
//   without_grid_error(on_two_grids[0].coarse.sequence, fit->errors[0]);   // what to judge it by
//
// Costs an estimate more than rounds: each is all frames' equilibria on both grids, and those of a
// grid of twice the nodes a side cost four to eight times as much. Pure; the same bytes for any
// number of threads.
#pragma once

#include <string>
#include <vector>

#include "server/estimation/sequences/discretisation/grid_error.h"
#include "server/estimation/staged/staged_fit.h"

namespace tenter::estimation {

/// A sequence on the grid of the fit, and on a finer one with the same channels and values.
struct OnTwoGrids {
  RoleSequence coarse;
  Sequence fine;
  double order = 1.3;     ///< of the convergence of what it observes (grid_error.h)
  bool is_fitted = true;  ///< else its error is estimated at the end, and that is all
};

/// The order that tests/bench/fabrics measures: 2 of strips on a table, whose edges the grid knows;
/// 1.7 on lines that were laid for the clips (material/grid_layout.h), dense towards corners inside
/// the cloth or equal where there are none; 1.3 on others.
double order_of(const Sequence& sequence, bool is_laid_for_clips);

/// The same measured values on the fine grid: a grid that holds other nodes sees others.
void measure_as(const Sequence& coarse, Sequence& fine);

struct GridFreeOptions {
  StageOptions stage;  ///< of each round; on_progress is also called before each estimate
  std::vector<std::vector<std::string>> ties;
  double share_as_sigma = 0.15;         ///< see GridErrorOptions
  int most_rounds = 3;                  ///< at least 1
  const model::Model* start = nullptr;  ///< of the staged fit that is the first round; none: of all
                                        ///< terms together, as the others
  StagedOptions staged = {};            ///< of that, but for what is said above
  double settled_sigmas = 0.1;
};

struct GridFreeFit {
  model::Model model;
  std::vector<GridError> errors;  ///< of each sequence, at this model
  int rounds = 0;
  std::vector<StageRecord> stages;              ///< of all rounds
  std::vector<std::vector<std::string>> terms;  ///< that each of these fitted
  bool settled = false;
  double change_sigmas = 0.0;  ///< of e, by the last round
  bool stopped = false;        ///< by on_progress; the model is that of the last round
};

/// `model`: fitted to the sequences as they are. A round that could not be done ends the fit: its
/// record says why, and the model is the one before. bad_input as grid_error() and fit_stage(), and
/// where there is nothing to fit to.
Expected<GridFreeFit> grid_free_fit(model::Model model, const std::vector<OnTwoGrids>& measured,
                                    const GridFreeOptions& options);

}  // namespace tenter::estimation
