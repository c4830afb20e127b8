// SPDX-License-Identifier: GPL-3.0-or-later
// Which frames of a sequence have a stable rest under a model: the others are left out of a fit,
// by name.
//
//   auto found = resting_frames(model, sequence, parameters, 1e-7);
//   keep_frames(sequence, found->resting);
//
// Frames are walked in order, each from where the last one with a rest was; a model that remembers
// its path goes from rest to rest, and knows nothing of a frame without one. Pure; one thread.
#pragma once

#include <string>
#include <vector>

#include "common/model/model.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation {

struct RestlessFrame {
  int frame = 0;  ///< from 0
  std::string reason;
};

struct RestingFrames {
  std::vector<int> resting;                ///< from 0
  std::vector<mechanics::State> states;    ///< of each of these
  std::vector<Eigen::VectorXd> by_node_N;  ///< dPi/dx there: reactions at clips
  std::vector<RestlessFrame> restless;
};

/// bad_input as check(), MeshModel::make and EquilibriumSolver::make.
Expected<RestingFrames> resting_frames(const model::Model& model, const Sequence& sequence,
                                       const Eigen::VectorXd& parameters, double tolerance_N);

/// At most so many of `all` frames, evenly over them and the last one with them; from 0.
std::vector<int> even_frames(int all, int most);

/// The same, but all of them for a model that remembers its path: each frame is a step of it.
std::vector<int> taken_frames(const model::Model& model, int all, int most);

/// Leaves only these, in their order.
void keep_frames(Sequence& sequence, const std::vector<int>& frames);

}  // namespace tenter::estimation
