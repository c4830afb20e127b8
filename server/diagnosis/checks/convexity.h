// SPDX-License-Identifier: GPL-3.0-or-later
// Is the elastic part of a model stable where it was measured? The Hessian of the elastic energy by
// the stretches and the shear of the test must be positive definite at every frame; path-dependent
// terms do not count.
//
//   lowest eigenvalue >= -slack * largest entry (by magnitude) of the Hessian
//
#pragma once

#include <vector>

#include "common/model/model.h"
#include "server/estimation/prediction.h"

namespace tenter::diagnosis {

struct Convexity {
  bool stable = true;
  int frames = 0;              ///< at which it is not
  std::vector<bool> unstable;  ///< every frame of every curve, in order
};

Convexity convexity(const model::Model& model, const estimation::DataSet& data,
                    double slack = 1e-9);

/// Frames at which `after` is unstable beyond the slack of a gate (a thousandth) and `before` is
/// stable.
int frames_made_unstable(const model::Model& before, const model::Model& after,
                         const estimation::DataSet& data);

}  // namespace tenter::diagnosis
