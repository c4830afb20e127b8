// SPDX-License-Identifier: GPL-3.0-or-later
// The smooth curve behind the noisy contour of a strip seen from the side: direction, curvature and
// the torque of its weight at any place, with what the noise does to them (thesis 5.3.3).
//
//   x(s) = x0 + integral_0^s (cos, sin) theta dt      theta: a cubic spline on even knots
//   kappa = theta'                                    (1/m)
//   T(s) = -rho g integral_s^L (x(t) - x(s)) dt = -rho g integral_s^L (L - t) cos theta(t) dt   (N)
//
// The spline is of the direction and not of the coordinates: its length is the strip's own, circles
// and spirals are followed exactly, and curvature is its first derivative. It is fitted to the
// distances of the points across the curve (their places along it are unknown), with twice
// as many intervals as the points call for (Akaike, corrected): what a smooth curve rounds off
// must be small beside its scatter, for that is what is told of it. Gravity points along -y; T is
// the torque per width that turns the part from s to the free end counterclockwise, as kappa
// counts.
//
// Points run from the clamp to the free end. Cost: 200 points, up to 16 intervals: 10 ms. Pure; any
// thread.
//
//   Expected<ProfileCurve> curve = ProfileCurve::fitted(points, {.length_m = 0.1});
//   double kappa = curve->curvature(0.03);
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/error.h"

namespace tenter::estimation {

struct ContourPoint {
  double x_m = 0.0;
  double y_m = 0.0;
};

struct ContourOptions {
  double length_m = 0.0;  ///< of the strip from the clamp to its free end; has to be given
  int intervals = 0;      ///< of the spline; 0: as many as the points call for
  int most_intervals = 16;
};

class ProfileCurve {
 public:
  /// bad_input for fewer than 12 points, numbers that are not finite, points that coincide all, or
  /// where no curve follows them.
  static Expected<ProfileCurve> fitted(const std::vector<ContourPoint>& points,
                                       const ContourOptions& options);

  double length_m() const { return length_; }
  int intervals() const { return intervals_; }
  /// Where along the strip each point lies, the first and the last at its ends (m).
  const std::vector<double>& arcs() const { return arcs_; }
  /// Standard deviation of a point across the curve (m).
  double noise_m() const { return noise_; }
  /// rms distance of the points from the curve (m).
  double rms_m() const { return rms_; }

  double direction(double arc_m) const;
  double curvature(double arc_m) const;
  ContourPoint position(double arc_m) const;
  /// T for a strip of `weight_N_m2` = rho g.
  double torque(double arc_m, double weight_N_m2) const;
  /// What direction and torque at a place change by with the spline's coefficients, and their
  /// covariance: scatter of anything made of them is g' C g.
  Eigen::VectorXd direction_by_coefficients(double arc_m) const;
  Eigen::VectorXd torque_by_coefficients(double arc_m, double weight_N_m2) const;
  const Eigen::MatrixXd& covariance() const { return covariance_; }

 private:
  struct Basis {
    int first = 0;
    double value[4];
    double slope[4];
  };
  Basis basis(double arc_m) const;
  void start(const std::vector<ContourPoint>& points, const std::vector<double>& arcs,
             const std::vector<double>& directions);
  bool improve(const std::vector<ContourPoint>& points, std::vector<double>& arcs);
  void lay_grid();
  Eigen::VectorXd torque_and_slopes(double arc_m, double weight_N_m2) const;

  double length_ = 0.0;
  int intervals_ = 0;
  double noise_ = 0.0;
  double rms_ = 0.0;
  std::vector<double> arcs_;
  ContourPoint origin_;
  Eigen::VectorXd coefficients_;
  Eigen::MatrixXd covariance_;  ///< of the coefficients
  /// At the borders of even cells: places, and their derivatives by the coefficients.
  std::vector<ContourPoint> grid_;
  Eigen::MatrixXd grid_x_by_c_, grid_y_by_c_;
};

}  // namespace tenter::estimation
