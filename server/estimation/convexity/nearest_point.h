// SPDX-License-Identifier: GPL-3.0-or-later
// The point of a polyhedron that is nearest to a given one:
//
//   minimise (x - x0)' M (x - x0)   subject to   rows x >= least
//
// as least distance programming: with M = L L', y = L'(x - x0), non-negative least squares of the
// dual (Lawson and Hanson, Solving Least Squares Problems, ch. 23; active sets, finite). Rows may
// repeat or depend on each other. Cost: a least-squares solve of (active rows) x n for each row
// that enters or leaves. Pure; allocates; any thread.
//
//   auto x = nearest_point(x0, metric, rows, least);   // metric of size 0: the identity
//   if (!x) ... no point holds all rows
#pragma once

#include <Eigen/Core>
#include <optional>

namespace tenter::estimation {

/// `metric` symmetric positive definite, or of size 0. None where the rows contradict each other
/// (or the metric is not definite).
std::optional<Eigen::VectorXd> nearest_point(const Eigen::VectorXd& x0,
                                             const Eigen::MatrixXd& metric,
                                             const Eigen::MatrixXd& rows,
                                             const Eigen::VectorXd& least);

/// min |a u - b| subject to u >= 0 (Lawson and Hanson's NNLS).
Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace tenter::estimation
