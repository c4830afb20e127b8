// SPDX-License-Identifier: GPL-3.0-or-later
// A profile as n samples of curvature and torque (thesis 5.3.3, fig. 5.7).
//
//   eps_i = 3 (theta(s_i + h/2) - theta(s_i - h/2)) / h       h = L/n: the mean over a piece of
//   strip T_iq  = torque of the weight at q = 1 ... 8 places of that piece
//
// The mean over a piece, not the curvature at a point: it is far less uncertain, and what a smooth
// curve rounds off within the piece does not change it. Predicted is the mean of eps over the T_iq.
//
// Left out are pieces in which gravity and the elastic torque oppose each other: there the strip
// did not go one way from the anchor to where it is. Gravity turns the strip back where T eps < 0.
// Cantilevers keep all: gravity bends them one way from flat.
//
// Pure; any thread. Cost: that of ProfileCurve::fitted.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "server/estimation/friction_tests/bending/strip_test.h"

namespace tenter::estimation {

constexpr int kTorquesPerSample = 8;

struct TorqueSample {
  double arc_m = 0.0;                     ///< middle of the piece
  double strain = 0.0;                    ///< measured mean (1/m)
  double std_error = 0.0;                 ///< of it
  double torque[kTorquesPerSample] = {};  ///< N
  double mean_torque() const;
};

struct ProfileSamples {
  int number = 0;       ///< of the StripTest
  double anchor = 0.0;  ///< strain on the cylinder, 0: never rolled
  int group = 0;        ///< of strips with the same radius
  double noise_m = 0.0;
  int intervals = 0;  ///< of the profile's spline
  std::vector<TorqueSample> samples;
  int left_out = 0;    ///< pieces where gravity and elasticity oppose
  ProfileCurve curve;  ///< of which all this was read
  std::vector<ContourPoint> points;
  double width_m = 0.0;      ///< of a piece
  double weight_N_m2 = 0.0;  ///< rho g
  /// What strains and torques change by with the spline's coefficients (samples x coefficients, and
  /// samples times places x coefficients), times a root of the coefficients' covariance.
  Eigen::MatrixXd strain_scatter, torque_scatter;
};

/// One entry for each strip, in order. bad_input names the strip whose profile no curve follows.
Expected<std::vector<ProfileSamples>> sampled(const BendingTests& tests);

}  // namespace tenter::estimation
