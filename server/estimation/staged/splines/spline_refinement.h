// SPDX-License-Identifier: GPL-3.0-or-later
// More control points for a curve that is there already (thesis 3.4.2: fits begin with one and
// subdivide).
//
//   model::Law four = with_points(three, 4).value();
//
// Control points are even over the law's range, or on the knots asked for. The new values are those
// whose curve is nearest to the old one, within the parameters' bounds: for B-splines of up to four
// points it is the same curve (their degree rises), from four to five too (a knot is added);
// Hermite curves come near. Pure.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/model/model.h"

namespace tenter::estimation {

/// Whether the law is a curve of one strain that can have any number of control points.
bool is_spline(const model::Law& law);

/// refused for a law that is none; bad_input for a number of points or knots that the law cannot
/// have, or a range that is not chosen yet where it needs one.
Expected<model::Law> with_points(const model::Law& law, int points,
                                 const std::vector<double>& knots = {});

/// The same for another law of `points` control points over the same range: the curve nearest to
/// the old one, as convex_spline to a fitted bspline_stiffness. Bounds as the old ones.
Expected<model::Law> nearest_curve(const model::Law& law, const std::string& name, int points,
                                   const std::vector<double>& knots = {});

/// A curve with one control point: the mean of the old ones. Where the law needs two at least, two.
model::Law as_constant(const model::Law& law);

}  // namespace tenter::estimation
