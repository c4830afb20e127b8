// SPDX-License-Identifier: GPL-3.0-or-later
// How far a model's rest is from what a sequence measured, frame by frame, in units of the noise;
// and in which frames distances of points mean anything (thesis 3.6).
//
//   const auto frames = frame_errors(sequence, fabric_model(fabric));
//   const MeanErrors all = mean_errors(frames);     // position 1.2, force 3.4 of the noise
//
// A frame without rest costs no other, but of a model that remembers its path. Aborts on a model
// that does not fit the sequence.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/sequences/folds/fold_comparison.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::twin {

struct FrameError {
  bool rests = false;         ///< else the rest is empty
  Eigen::VectorXd positions;  ///< (simulated - measured) / sigma, of coordinates that were seen
  Eigen::VectorXd forces;
  bool has_folds = false;  ///< `folds` is there
  estimation::FoldComparison folds;

  bool means_something() const { return !has_folds || estimation::is_meaningful(folds.positions); }
};

std::vector<FrameError> frame_errors(const estimation::Sequence& sequence,
                                     const model::Model& model);

/// Root mean squares.
struct MeanErrors {
  double position = 0.0;
  double position_where_meaningful = 0.0;
  double force = 0.0;
  int lost = 0;         ///< frames without rest
  int meaningless = 0;  ///< frames whose distances of points say nothing
};
MeanErrors mean_errors(const std::vector<FrameError>& frames);

}  // namespace tenter::twin
