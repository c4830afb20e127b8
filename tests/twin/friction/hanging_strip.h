// SPDX-License-Identifier: GPL-3.0-or-later
// A twin of the bending tests of thesis 5.3.3: a strip held at one end, seen from the side, as it
// hangs (the cantilever) or after it was rolled around a cylinder and let go (a spiral).
//
//   M(s) = -rho g integral_s^L (x(t) - x(s)) dt = stress(eps(s)),   eps = 3 kappa = 3 theta'
//
// M is the torque of gravity per width. A chain of hinges creeps from the rolled (or straight)
// strip to rest, each hinge as fast as its torques differ. Layers do not touch each other.
//
//   one_way   friction is that of one way from the cylinder's curvature to where the hinge is, as
//             the papers take it (5.4) of a strip unrolled with care; a stress that falls on the
//             way is passed in a snap
//   creeping  every hinge carries its friction along the way it really goes, to and fro where
//             gravity wants that: a strip that was let go
//
//   StripPlan plan{.radius_m = 0.004};
//   RestingStrip strip = resting_strip(bending_samples()[0], plan);
//   std::vector<StripPoint> points = photographed(strip, 1e-4, seed);
#pragma once

#include <cstdint>
#include <vector>

#include "tests/twin/friction/friction_sample.h"

namespace tenter::twin {

enum class Unrolling { one_way, creeping };

struct StripPlan {
  double radius_m = 0.0;  ///< of the cylinder; 0: never rolled
  double length_m = 0.1;
  double clamp_angle_rad = -1.5707963267948966;  ///< of the strip at the clamp, from x towards y
  double gravity_m_s2 = 9.81;
  int hinges = 200;
  Unrolling unrolling = Unrolling::one_way;
};

/// The cantilever's: held level, bending to the sense in which spirals roll.
constexpr double kCantileverAngle = 3.14159265358979323846;

struct StripPoint {
  double x_m = 0.0;
  double y_m = 0.0;
};

/// At evenly spaced places, from the clamp to the free end.
struct RestingStrip {
  double length_m = 0.0;
  bool is_at_rest = false;
  std::vector<StripPoint> points;
  std::vector<double> strain;    ///< 3 kappa (1/m)
  std::vector<double> torque_N;  ///< of gravity, per width
  std::vector<double> way_back;  ///< how far each went back from its farthest (1/m)
};

RestingStrip resting_strip(const FrictionSample& sample, const StripPlan& plan);

/// Its contour, point by point, with noise on each coordinate.
std::vector<StripPoint> photographed(const RestingStrip& strip, double noise_m, std::uint64_t seed);

/// The length at which a cantilever's chord falls by 41.5 degrees, as the standard test has it.
double cantilever_length(const FrictionSample& sample);

}  // namespace tenter::twin
