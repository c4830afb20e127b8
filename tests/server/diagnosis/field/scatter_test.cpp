// SPDX-License-Identifier: GPL-3.0-or-later
// Noise of one under misfits of all kinds.
#include "server/diagnosis/field/noise/scatter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/diagnosis/screening/normal.h"

namespace tenter::diagnosis {
namespace {

constexpr int kChannels = 6;

/// A bar that goes out and back `loops` times, `a_branch` frames each way, unevenly.
estimation::Sequence loops_of(int loops, int a_branch) {
  estimation::Sequence sequence;
  sequence.boundaries.resize(1);
  for (int branch = 0; branch < 2 * loops; ++branch)
    for (int k = 0; k < a_branch; ++k) {
      const double share = std::pow((k + 0.5) / a_branch, 1.2);
      const double way_m =
          0.01 * (branch % 2 == 0 ? share : std::pow((a_branch - k - 0.5) / a_branch, 1.2));
      auto& frame = sequence.frames.emplace_back();
      frame.clips.push_back({Eigen::Matrix3d::Identity(), {way_m, 0.0, 0.0}});
      frame.block = branch;
    }
  return sequence;
}

/// What the noise of one channel after another, with a misfit of (way from 0 to 1, branch), shows.
template <class Misfit>
Scatter shown(const estimation::Sequence& sequence, const Misfit& misfit, double noise = 1.0,
              unsigned long long seed = 1) {
  const FrameContrasts frames(sequence);
  Normal normal(seed);
  Looks looks;
  for (int c = 0; c < kChannels; ++c) {
    std::vector<double> values;
    for (const auto& frame : sequence.frames)
      values.push_back(noise * normal() +
                       misfit(frame.clips[0].position_m.x() / 0.01, frame.block) * (1.0 + 0.3 * c));
    looks.add(frames, values);
  }
  return looks.scatter();
}

double none(double, int) {
  return 0.0;
}
/// A hundred times the noise, and strongly curved.
double curved(double way, int) {
  return 100.0 * std::exp(3.0 * way) / std::exp(3.0);
}

/// Mean of the logarithm over seeds, so that no lucky one decides.
template <class Misfit>
double mean_spread(const estimation::Sequence& sequence, const Misfit& misfit) {
  double sum = 0.0;
  constexpr int kSeeds = 40;
  for (int seed = 1; seed <= kSeeds; ++seed)
    sum += std::log(shown(sequence, misfit, 1.0, static_cast<unsigned long long>(seed)).spread);
  return std::exp(sum / kSeeds);
}

TEST(Scatter, OfWhiteNoiseIsTheNoise) {
  for (const int a_branch : {4, 8, 20}) {
    const auto sequence = loops_of(1, a_branch);
    EXPECT_NEAR(mean_spread(sequence, none), 1.0, a_branch == 4 ? 0.15 : 0.1) << a_branch;
    int bounds = 0;
    for (int seed = 1; seed <= 40; ++seed)
      bounds += shown(sequence, none, 1.0, static_cast<unsigned long long>(seed)).is_bound ? 1 : 0;
    EXPECT_LE(bounds, 6) << a_branch;
  }
}

/// A line through the neighbours of a frame would show several times the noise.
TEST(Scatter, LeavesOutWhatIsCurved) {
  const auto sequence = loops_of(1, 8);
  const FrameContrasts frames(sequence);
  std::vector<double> misfit;
  for (const auto& frame : sequence.frames)
    misfit.push_back(curved(frame.clips[0].position_m.x() / 0.01, 0));
  double second = 0.0;
  for (const Contrast& contrast : frames.differences.front())
    second = std::max(second, std::abs(contrast.of(misfit)));
  ASSERT_GT(second, 3.5);
  EXPECT_NEAR(mean_spread(sequence, curved), 1.0, 0.25);
}

TEST(Scatter, OfRepeatedPosesIsTheNoise) {
  // three frames a branch leave nothing for differences to settle
  const auto sequence = loops_of(3, 3);
  EXPECT_NEAR(mean_spread(sequence, curved), 1.0, 0.15);
  EXPECT_FALSE(shown(sequence, curved).is_bound);
  // what lags is other on the way back, but the same in each loop
  const auto lags = [](double way, int branch) {
    return curved(way, 0) + (branch % 2 ? -30.0 : 30.0);
  };
  EXPECT_NEAR(mean_spread(sequence, lags), 1.0, 0.25);
}

/// Of a lag in one loop of a few frames nothing says what is noise: no more than a bound.
TEST(Scatter, SaysWhereItIsABound) {
  const auto lags = [](double way, int branch) {
    return curved(way, 0) + (branch % 2 ? -60.0 : 60.0);
  };
  const Scatter scatter = shown(loops_of(1, 3), lags);
  EXPECT_GT(scatter.spread, 3.0);
  EXPECT_TRUE(scatter.is_bound);
  EXPECT_EQ(shown(loops_of(1, 2), none).values, 2 * kChannels);  // both ways, and no differences
}

}  // namespace
}  // namespace tenter::diagnosis
