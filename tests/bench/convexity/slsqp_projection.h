// SPDX-License-Identifier: GPL-3.0-or-later
// The rival of the convexity bench: the projection of thesis 4.3.3 by NLopt's SLSQP, with each
// eigenvalue as a constraint of its own: linear for addends of one strain, trace and determinant of
// the 2 x 2 matrices for those of two.
#pragma once

#include <Eigen/Core>

#include "server/estimation/convexity/convexity_constraints.h"

namespace tenter::bench {

struct SlsqpResult {
  bool ran = false;  ///< false: built without NLopt, or it failed
  Eigen::VectorXd parameters;
  int evaluations = 0;
};

SlsqpResult project_by_slsqp(const estimation::ConvexityConstraints& constraints,
                             const Eigen::VectorXd& parameters);

}  // namespace tenter::bench
