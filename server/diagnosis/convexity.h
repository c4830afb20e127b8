// SPDX-License-Identifier: GPL-3.0-or-later
// Is the elastic part of a model stable where it was measured? The Hessian of the elastic energy by
// the stretches and the shear of the test must be positive definite at every frame; path-dependent
// terms do not count.
#pragma once

#include "common/model/model.h"
#include "server/estimation/prediction.h"

namespace tenter::diagnosis {

struct Convexity {
  bool stable = true;
  int frames = 0;  ///< at which it is not
};

Convexity convexity(const model::Model& model, const estimation::DataSet& data);

}  // namespace tenter::diagnosis
