// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/friction_test/strips/strips_of_captures.h"

#include <cmath>

#include "common/capture/strips/strip_profiles.h"
#include "server/jobs/friction_test/axis_of_cloth.h"

namespace tenter::jobs {
namespace {

bool are_equal(double one, double other) {
  constexpr double kSlack = 1e-6;
  return std::abs(one - other) <= kSlack * std::abs(one);
}

}  // namespace

Expected<StripsOfCaptures> strips_of(
    const std::vector<std::pair<std::string, capture::Capture>>& captures) {
  StripsOfCaptures result;
  estimation::BendingTests& tests = result.tests;
  for (std::size_t c = 0; c < captures.size(); ++c) {
    const capture::Capture& capture = captures[c].second;
    const std::string name = "capture \"" + capture.title + "\": ";
    if (capture.kind != capture::kStripsKind)
      return bad_input(name + "its kind is " + capture.kind + "; spirals and cantilevers are " +
                       capture::kStripsKind);
    const auto profiles = capture::strip_profiles(capture);
    if (!profiles) return bad_input(name + profiles.error().message);
    const std::string axis = axis_of_cloth(capture.specimen.axis_angle_rad);
    if (axis.empty())
      return bad_input(name +
                       "specimen.axis_angle: its strips lie along neither weft nor warp; friction "
                       "is estimated for each of them on its own");
    const double density = *capture.specimen.area_density_kg_m2;
    if (c == 0) {
      result.measure = "bend_" + axis;
      tests.area_density_kg_m2 = density;
    }
    if ("bend_" + axis != result.measure)
      return bad_input(name +
                       "specimen.axis_angle: its strips lie along another direction of the cloth "
                       "than those of the first capture; fit them apart");
    if (!are_equal(tests.area_density_kg_m2, density))
      return bad_input(name + "specimen.area_density: is another one than the first capture's");
    for (const capture::StripProfile& profile : *profiles) {
      estimation::StripTest strip;
      for (const auto& point : profile.points_m) strip.points.push_back({point[0], point[1]});
      strip.length_m = profile.length_m;
      strip.radius_m = profile.radius_m;
      strip.sense = profile.sense;
      strip.number = static_cast<int>(result.places.size());
      tests.strips.push_back(std::move(strip));
      result.places.push_back({c, profile.first_frame});
    }
  }
  return result;
}

}  // namespace tenter::jobs
