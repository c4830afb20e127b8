// SPDX-License-Identifier: GPL-3.0-or-later
// A square of cloth in a picture frame of four rigid bars on hinges, sheared to and fro: the
// full-field sequence that shear friction is recovered from.
#pragma once

#include <vector>

#include "common/model/model.h"
#include "server/estimation/sequences/sequence.h"

namespace tenter::estimation::testing {

/// cloth_stvk with friction in shear; six linear stiffnesses, then a, b, c (known) and tau.
model::Model rubbing_cloth(const Eigen::VectorXd& values);
/// N/m, bending N m, friction N/m and a strain.
Eigen::VectorXd rubbing_values();

/// Bars hold the middle of each side, so that corners are free and the strain is not uniform. The
/// frame opens a little, is sheared and comes back in parts only. Every node is seen, and the
/// forces of two bars. `nodes` a side. What is measured is zero: see measure().
Sequence picture_frame(int nodes);

/// What the model shows, with normal noise of the channels' sigmas times `noise`. Fails the test
/// where a frame has no rest.
void measure(Sequence& sequence, const model::Model& model, const Eigen::VectorXd& truth,
             double noise, unsigned seed);

}  // namespace tenter::estimation::testing
