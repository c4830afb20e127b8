// SPDX-License-Identifier: GPL-3.0-or-later
// Spirals and cantilevers of one sample of table 5.2.
#pragma once

#include <vector>

#include "server/estimation/friction_tests/bending/bending_fit.h"
#include "tests/bench/friction_tests/coverage_table.h"
#include "tests/twin/friction/hanging_strip.h"

namespace tenter::bench {

/// The papers' protocol: twelve radii and the cantilever, three times each.
class BendingRig {
 public:
  BendingRig(const twin::FrictionSample& sample, twin::Unrolling unrolling);
  estimation::BendingTests photographed(std::uint64_t seed) const;
  /// Strips that found no rest in the twin and are left out.
  int restless() const { return restless_; }
  const twin::FrictionSample& sample() const { return sample_; }

 private:
  twin::FrictionSample sample_;
  std::vector<twin::RestingStrip> strips_;
  std::vector<double> radii_m_;
  int restless_ = 0;
};

CoverageTable bending_coverage(const BendingRig& rig, const CoverageOptions& options);

}  // namespace tenter::bench
