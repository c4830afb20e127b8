// SPDX-License-Identifier: GPL-3.0-or-later
// Where a stiffness curve wants its next knot: in the piece in which most of what is left of the
// cost lies, at the strain that halves it.
//
// The cost of a frame counts at the strains of its elements, by their area; so a curve that is too
// stiff or too soft over a few strains draws knots there, whatever the rest of the range is like.
//
//   costs = frame_costs(residuals, evaluator.rows(), states);
//   left = strain_histograms(mesh, states[0], costs[0]);
//   knots = inner_knots(law, points, left[term]);
//
// Pure; a pass over the histogram for each knot.
#pragma once

#include <vector>

#include "common/model/model.h"
#include "server/estimation/residual_function.h"
#include "server/estimation/staged/splines/strain_histogram.h"

namespace tenter::estimation {

/// What the rows of each frame of each sequence add to the cost.
std::vector<std::vector<double>> frame_costs(
    const Eigen::VectorXd& residuals, const std::vector<Row>& rows,
    const std::vector<std::vector<mechanics::State>>& states);

/// For `points` control points, at least as many as the law has: its own knots and those that it
/// lacks. The law has a range. Where nothing is left the widest piece is halved.
std::vector<double> inner_knots(const model::Law& law, int points, const StrainHistogram& left);

}  // namespace tenter::estimation
