// SPDX-License-Identifier: Apache-2.0
#include "common/capture/csv/branch_detection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/common/capture/support.h"

namespace tenter::capture {
namespace {

struct Signal {
  std::vector<double> time;
  std::vector<double> value;
  /// Adds a straight piece to `target` lasting `seconds`, 50 readings a second.
  void to(double target, double seconds) {
    const double start = value.empty() ? 0.0 : value.back();
    const double t0 = time.empty() ? 0.0 : time.back();
    const int n = static_cast<int>(seconds * 50);
    for (int i = value.empty() ? 0 : 1; i <= n; ++i) {
      value.push_back(start + (target - start) * i / n);
      time.push_back(t0 + seconds * i / n);
    }
  }
  void disturb(double sigma) {
    std::mt19937 generator(5);
    std::normal_distribution<double> noise(0.0, sigma);
    for (double& v : value) v += noise(generator);
  }
};

/// Pieces of one branch, as letters: "LHU".
std::string pieces(const std::vector<Branch>& branch) {
  std::string out;
  for (std::size_t i = 0; i < branch.size(); ++i)
    if (i == 0 || branch[i] != branch[i - 1]) out += "LUHO"[static_cast<int>(branch[i])];
  return out;
}

TEST(BranchDetection, FindsTurningPointsAndHoldsUnderNoise) {
  Signal s;
  s.to(0.1, 4);
  s.to(0.1, 20);
  s.to(0.02, 3);
  s.to(0.08, 3);
  s.to(0.0, 4);
  for (const double sigma : {0.0, 0.0002, 0.001}) {
    Signal noisy = s;
    noisy.disturb(sigma);
    EXPECT_EQ(pieces(detect_branches(noisy.value, noisy.time)), "LHULU") << sigma;
  }
}

TEST(BranchDetection, PutsTheTurnAtTheExtreme) {
  Signal s;
  s.to(1, 2);
  s.to(0, 2);
  const std::vector<Branch> branch = detect_branches(s.value, s.time);
  const auto first_unload = std::find(branch.begin(), branch.end(), Branch::unload);
  EXPECT_EQ(first_unload - branch.begin(), 101);
}

TEST(BranchDetection, ASineIsNotHeldAtItsPeaks) {
  Signal s;
  for (int i = 0; i < 800; ++i) {
    s.time.push_back(i / 100.0);
    s.value.push_back(std::sin(2 * M_PI * i / 200.0));
  }
  EXPECT_EQ(pieces(detect_branches(s.value, s.time)), "LULULULUL");
}

TEST(BranchDetection, FindsLongHoldsThatAreThinnedOut) {
  Signal s;
  s.to(1, 4);
  for (int i = 1; i <= 30; ++i) {
    s.time.push_back(s.time.back() + 60);
    s.value.push_back(1.0);
  }
  EXPECT_EQ(pieces(detect_branches(s.value, s.time)), "LH");
}

TEST(BranchDetection, WithoutTimesCountsFrames) {
  Signal s;
  s.to(1, 2);
  s.to(0.2, 2);
  EXPECT_EQ(pieces(detect_branches(s.value, {})), "LU");
}

TEST(BranchDetection, TakesShortAndStillSignals) {
  EXPECT_EQ(pieces(detect_branches({}, {})), "");
  EXPECT_EQ(pieces(detect_branches({1}, {0})), "H");
  EXPECT_EQ(pieces(detect_branches({1, 2}, {0, 1})), "L");
  EXPECT_EQ(pieces(detect_branches({2, 1}, {0, 1})), "U");
  EXPECT_EQ(pieces(detect_branches(std::vector<double>(50, 3.0), {})), "H");
}

TEST(BranchDetection, FollowsThePrescribedComponentThatMoves) {
  Capture c = test::small_capture();
  EXPECT_EQ(driving_component(c, 0, 3), (std::vector<double>{1, 1.1, 1.2}));
  // nothing prescribed: what is observed
  c.kinematics.x = {};
  EXPECT_EQ(driving_component(c, 0, 3).size(), 3U);
  c.kinematics.y = {};
  EXPECT_TRUE(driving_component(c, 0, 3).empty());
}

}  // namespace
}  // namespace tenter::capture
