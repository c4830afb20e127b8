// SPDX-License-Identifier: GPL-3.0-or-later
// The convex energy nearest to a given one (thesis 4.3.3):
//
//   minimise (p - p_bar)' M (p - p_bar)   subject to (4.11) at the samples of ConvexityConstraints
//
// M is the identity (the thesis) or a metric of the data such as J'J, which gives up the least of
// the fit. Energies are linear in p, so the problem is convex and has one answer: rows that are
// broken, and cuts along the eigenvectors of matrices that are not positive, are added to a
// quadratic programme until none is broken (cutting planes). Pure; allocates; any thread; the same
// bytes each time.
//
//   const ConvexProjection at = project_onto_convex(constraints, p_bar);
//   if (at.status == ConvexStatus::ok) p = at.parameters;
#pragma once

#include <Eigen/Core>

#include "server/estimation/convexity/convexity_constraints.h"

namespace tenter::estimation {

enum class [[nodiscard]] ConvexStatus{
    ok,
    infeasible,     ///< no values within the bounds, with the fixed ones as they are, are convex
    no_convergence  ///< rounds were used up; the parameters are nearer, but some sample is broken
};

struct ConvexProjection {
  ConvexStatus status = ConvexStatus::ok;
  Eigen::VectorXd parameters;
  int rounds = 0;  ///< quadratic programmes solved; 0: was convex already
  int rows = 0;    ///< rows and cuts in the last of them
};

struct ProjectionOptions {
  double slack = 1e-9;  ///< of eigenvalues, relative (add_broken)
  int max_rounds = 100;
};

/// `metric`: parameters x parameters, symmetric positive definite; of size 0: the identity. Fixed
/// parameters stay where they are.
ConvexProjection project_onto_convex(const ConvexityConstraints& constraints,
                                     const Eigen::VectorXd& parameters,
                                     const Eigen::MatrixXd& metric = {},
                                     const ProjectionOptions& options = {});

}  // namespace tenter::estimation
