// SPDX-License-Identifier: GPL-3.0-or-later
// What a model shows on a sequence, frame by frame, wherever it has a rest there.
//
//   auto seen = predict(model, sequence, threads);
//   Misfit force = misfit(sequence, *seen, estimation::ObservationKind::force);
//
// Frames without a stable rest are named and predict nothing (NaN). Same bytes for any number of
// threads.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/sequences/observations.h"
#include "server/estimation/staged/resting_frames.h"

namespace tenter::jobs {

struct Prediction {
  Eigen::MatrixXd value;  ///< channels (Observations) x frames of the sequence
  std::vector<std::optional<mechanics::State>> states;  ///< of each frame
  std::vector<estimation::RestlessFrame> restless;
};

Expected<Prediction> predict(const model::Model& model, const estimation::Sequence& sequence,
                             int threads, double tolerance_N = 1e-7);

/// Over the readings of one kind that were measured and predicted.
struct Misfit {
  int rows = 0;
  double square = 0.0;         ///< sum of (measured - predicted)^2, in N^2 or m^2
  double square_sigmas = 0.0;  ///< the same in standard deviations
  double sigma_square = 0.0;   ///< sum of sigma^2

  Misfit& operator+=(const Misfit& other);
};
Misfit misfit(const estimation::Sequence& sequence, const Prediction& prediction,
              estimation::ObservationKind kind);
/// Of one frame.
Misfit misfit(const estimation::Sequence& sequence, const Prediction& prediction,
              estimation::ObservationKind kind, std::size_t frame);

}  // namespace tenter::jobs
