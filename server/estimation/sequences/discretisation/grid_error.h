// SPDX-License-Identifier: GPL-3.0-or-later
// How far is a grid from h = 0 on what a sequence observes, and how does a fit do without that?
//
//   y(h) = y(0) + c h^p                                        of every channel in every frame
//   e = y(0) - y(coarse) = (y(fine) - y(coarse)) / (1 - (h_fine / h_coarse)^p)
//   measured' = measured - e          sigma'^2 = sigma^2 + (share rms_frames(e))^2
//
// (L. F. Richardson, Phil. Trans. R. Soc. A 210, 1911.) Clips end in the cloth with corners where
// stresses have no bound, so forces converge by an order below two: 1.2 to 1.4 for the twin fabrics
// in the picture frame and at pulled corners (tests/bench/fabrics).
//
//   auto error = grid_error(fitted, coarse, fine, {});
//   if (!error) return tl::unexpected(error.error());
//   Sequence better = without_grid_error(coarse, *error);    // fit again, predict against it
//
// The curves need only be near: e is small, and its change with them smaller. Where the two grids
// fold at different places e of the positions says nothing (see folds/): so it is of forces,
// torques and areas alone unless asked for. A model that remembers its path goes along it on both
// grids, up to the first frame that has no rest on one. Pure; cost is each frame's equilibrium on
// both grids.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation {

struct GridErrorOptions {
  double order = 1.3;            ///< p, above 0
  bool of_positions = false;     ///< and lengths; else of the others alone
  double share_as_sigma = 0.15;  ///< how wrong e is; at least 0
  int threads = 1;               ///< the same bytes for any number
};

/// e of each frame, as the sequence has its measured values; zero where it is not estimated.
struct GridError {
  struct Frame {
    bool rests = false;  ///< on both grids; else there is no estimate, and all of it is zero
    Eigen::Matrix3Xd points_m;
    Eigen::VectorXd forces_N, scalars;
  };
  std::vector<Frame> frames;
  double share_as_sigma = 0.0;
};

/// Both sequences have the same channels, frames and measured values, `fine` the smaller triangles:
/// h is the root of twice their mean area.
/// bad_input where that is not so, for options out of bounds, and as SequenceEvaluator::make().
Expected<GridError> grid_error(const model::Model& model, const Sequence& coarse,
                               const Sequence& fine, const GridErrorOptions& options);

/// `sequence` is the coarse one. Frames without an estimate have no measured forces and scalars any
/// more: what they show is not comparable with the others.
Sequence without_grid_error(Sequence sequence, const GridError& error);

/// How large e is, over the values that frames with an estimate measured.
struct GridErrorSize {
  double rms = 0.0;      ///< m or N
  double largest = 0.0;  ///< magnitude
  double sigmas = 0.0;   ///< rms of e / sigma
  int rows = 0;          ///< none: all of it is zero
};
/// `sequence`: the coarse one, with the sigmas that it was measured with.
GridErrorSize size_of(const GridError& error, const Sequence& sequence, ObservationKind kind);

}  // namespace tenter::estimation
