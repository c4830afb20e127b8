// SPDX-License-Identifier: GPL-3.0-or-later
// Tests of bending: strips held at one end, seen from the side (thesis 5.3.3).
//
//   spiral       rolled around a cylinder of known radius, then unrolled with care: the cylinder is
//                the anchor, eps = 3 / radius
//   cantilever   never rolled: bent by its own weight from flat (Clapp et al.), for the stiffness
//
// Points run from the clamp to the free end, gravity along -y. Cloth may answer differently to
// either sense of curvature: by_sense() parts the tests by what is told of them, else by how they
// bend, and mirrors profiles of negative curvature, so that all that follows sees it above zero.
//
// SI units; pure; any thread.
#pragma once

#include <array>
#include <vector>

#include "server/estimation/friction_tests/bending/profile_curve.h"

namespace tenter::estimation {

struct StripTest {
  std::vector<ContourPoint> points;
  double length_m = 0.0;  ///< from the clamp to the free end
  double radius_m = 0.0;  ///< of the cylinder; 0: a cantilever
  int sense = 0;          ///< 1 or -1: to which face it was rolled; 0: as the profile bends
  int number = 0;         ///< the caller's own, kept by its ProfileSamples
};

struct BendingTests {
  std::vector<StripTest> strips;
  double area_density_kg_m2 = 0.0;
  double gravity_m_s2 = 9.80665;
  int samples = 5;  ///< of each profile (n of the papers)
};

enum class BendingProtocol {
  spirals,     ///< with or without cantilevers: at least one spiral and two strips in all
  cantilevers  ///< at least one, and no spiral
};

/// bad_input that names the strip: sizes above zero, radii not negative, points that are numbers;
/// and what the protocol needs.
Expected<BendingTests> check(BendingTests tests,
                             BendingProtocol protocol = BendingProtocol::spirals);

/// Positive sense first; profiles that bend clockwise are mirrored (x to -x).
std::array<BendingTests, 2> by_sense(const BendingTests& tests);

}  // namespace tenter::estimation
