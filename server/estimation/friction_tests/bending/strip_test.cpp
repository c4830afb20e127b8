// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/bending/strip_test.h"

#include <cmath>
#include <string>
#include <utility>

namespace tenter::estimation {
namespace {

bool is_positive(double value) {
  return std::isfinite(value) && value > 0.0;
}

/// Twice the area between the profile and the chord of its ends: whose sign is the side on which
/// it bulges, and so the sense in which it bends.
double bulge(const std::vector<ContourPoint>& points) {
  double area = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ContourPoint& a = points[i];
    const ContourPoint& b = points[(i + 1) % points.size()];
    area += a.x_m * b.y_m - b.x_m * a.y_m;
  }
  return area;
}

}  // namespace

Expected<BendingTests> check(BendingTests tests, BendingProtocol protocol) {
  if (!is_positive(tests.area_density_kg_m2))
    return bad_input("the mass per area of the cloth is not above zero");
  if (!is_positive(tests.gravity_m_s2)) return bad_input("gravity is not above zero");
  if (tests.samples < 1 || tests.samples > 40)
    return bad_input("a profile is sampled at 1 to 40 places, " + std::to_string(tests.samples) +
                     " are asked for");
  int spirals = 0;
  for (std::size_t i = 0; i < tests.strips.size(); ++i) {
    const StripTest& strip = tests.strips[i];
    const std::string name = "strip " + std::to_string(i + 1) + ": ";
    if (!is_positive(strip.length_m)) return bad_input(name + "the length is not above zero");
    if (!std::isfinite(strip.radius_m) || strip.radius_m < 0.0)
      return bad_input(name + "the radius of the cylinder is negative");
    for (const ContourPoint& point : strip.points)
      if (!std::isfinite(point.x_m) || !std::isfinite(point.y_m))
        return bad_input(name + "a point is not a number");
    spirals += strip.radius_m > 0.0 ? 1 : 0;
  }
  if (protocol == BendingProtocol::cantilevers) {
    if (tests.strips.empty()) return bad_input("there is no cantilever");
    if (spirals > 0)
      return bad_input(std::to_string(spirals) +
                       " of the strips were rolled around a cylinder: these are spirals");
    return tests;
  }
  if (spirals == 0)
    return bad_input("no strip was rolled around a cylinder: friction shows in spirals");
  if (tests.strips.size() < 2) return bad_input("one strip alone does not determine a model");
  return tests;
}

std::array<BendingTests, 2> by_sense(const BendingTests& tests) {
  std::array<BendingTests, 2> parts = {tests, tests};
  for (BendingTests& part : parts) part.strips.clear();
  for (StripTest strip : tests.strips) {
    const bool is_clockwise = bulge(strip.points) < 0.0;
    if (is_clockwise)
      for (ContourPoint& point : strip.points) point.x_m = -point.x_m;
    const bool is_negative = strip.sense == 0 ? is_clockwise : strip.sense < 0;
    parts[is_negative ? 1 : 0].strips.push_back(std::move(strip));
  }
  return parts;
}

}  // namespace tenter::estimation
