// SPDX-License-Identifier: GPL-3.0-or-later
// How a sheet is folded: height, wavelength and direction of its folds, whatever their phase.
//
// Where cloth wrinkles, "even a small change in material properties may lead to distant stable
// configurations in the L2 sense" (thesis 3.6): two sheets with the same folds, shifted by half a
// wavelength, differ by twice their height at every point. Here they are the same.
//
//   x(u, v) = smooth(u, v) + w(u, v) n(u, v)
//   W(k) = sum_j h(u_j) h(v_j) w_j exp(-i k . (u_j, v_j))
//   P(k) = |W|^2 - sigma^2 sum_j (h h)^2
//
// smooth: least squares by polynomials of the fourth degree, n its normal; h: Hann window, points
// anywhere; P is without what white noise puts there.
//
//   height      sqrt(2) rms of w, without the noise (of a sinusoid: its amplitude)
//   wavelength  2 pi over the mean |k| of the peak of P, down to half of it
//   direction   across the folds, from the mean of exp(2 i angle) over P
//   alignment   length of that mean: 1 where all folds are parallel, 0 where they have no direction
//
//   auto folds = measure_folds({material_m, positions_m}, 7.5e-5);
//   if (folds->is_folded) ... folds->wavelength_m
//
// What is longer than two thirds of the side is shape, not folds; of three folds to a side the
// smooth part takes some height (10 %) and the wavelength comes out 8 % too long, of four and more
// both are right to 5 %. Pure; O(points x wave vectors), some 2,000 of these; callable from any
// thread.
#pragma once

#include <Eigen/Core>

#include "common/base/error.h"

namespace tenter::estimation {

/// Material places and where they are; columns with a number that is none are left out.
struct SheetPoints {
  Eigen::Matrix2Xd material_m;
  Eigen::Matrix3Xd position_m;
};

struct FoldMeasure {
  bool is_folded = false;  ///< there is a peak that noise does not make; else the rest is empty
  double height_m = 0.0;
  double wavelength_m = 0.0;   ///< in the material
  double direction_rad = 0.0;  ///< from u towards v, 0 to pi
  double alignment = 0.0;
  double steepness = 0.0;    ///< 2 pi height / wavelength: the slope of a fold's side
  Eigen::VectorXd relief_m;  ///< w, one a point; zero where it was left out
};

/// `sigma_m`: standard deviation of a coordinate. bad_input: lists that do not match, fewer than 40
/// points, points on one line, a sigma that is negative or no number.
Expected<FoldMeasure> measure_folds(const SheetPoints& points, double sigma_m);

}  // namespace tenter::estimation
