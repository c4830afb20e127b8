// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/friction_tests/bending_case.h"

#include <cstdio>

namespace tenter::bench {

namespace {
constexpr int kRepeats = 3;
constexpr double kNoise = 1e-4;  // m, of each coordinate
}  // namespace

BendingRig::BendingRig(const twin::FrictionSample& sample, twin::Unrolling unrolling)
    : sample_(sample) {
  for (const double radius_mm :
       {0.0, 3.0, 4.0, 5.0, 6.0, 7.0, 7.5, 10.0, 16.0, 23.0, 27.5, 31.5, 50.0}) {
    twin::StripPlan plan;
    plan.radius_m = 1e-3 * radius_mm;
    plan.unrolling = unrolling;
    if (radius_mm == 0.0) {
      plan.clamp_angle_rad = twin::kCantileverAngle;
      plan.length_m = twin::cantilever_length(sample);
    }
    twin::RestingStrip strip = twin::resting_strip(sample, plan);
    if (!strip.is_at_rest) ++restless_;
    strips_.push_back(std::move(strip));
    radii_m_.push_back(plan.radius_m);
  }
}

estimation::BendingTests BendingRig::photographed(std::uint64_t seed) const {
  estimation::BendingTests tests;
  tests.area_density_kg_m2 = sample_.density_kg_m2;
  tests.gravity_m_s2 = 9.81;
  std::uint64_t picture = seed * 1000;
  for (std::size_t i = 0; i < strips_.size(); ++i)
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      estimation::StripTest strip;
      for (const twin::StripPoint& p : twin::photographed(strips_[i], kNoise, ++picture))
        strip.points.push_back({p.x_m, p.y_m});
      strip.length_m = strips_[i].length_m;
      strip.radius_m = radii_m_[i];
      tests.strips.push_back(std::move(strip));
    }
  return tests;
}

CoverageTable bending_coverage(const BendingRig& rig, const CoverageOptions& options) {
  return covered(rig.sample(), options, [&](int seed) -> Expected<estimation::FrictionEstimate> {
    auto found = fit_bending(rig.photographed(static_cast<std::uint64_t>(seed)), "bend_v",
                             {.profiles = options.profiles});
    if (!found) return tl::unexpected(found.error());
    if (seed == 1)
      std::printf(
          "\n%s, first seed: %d strips at no rest in the twin, %d of %d samples left out, "
          "cantilever alone k1 %.4g k2 %.4g, points' noise %.3g mm\n",
          rig.sample().name.c_str(), rig.restless(), found->left_out,
          found->left_out + static_cast<int>(found->predicted.size()), found->cantilever.k1,
          found->cantilever.k2, 1e3 * found->friction.noise);
    return std::move(found->friction);
  });
}

}  // namespace tenter::bench
