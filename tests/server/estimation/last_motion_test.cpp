// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/instrument/last_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace tenter::estimation {
namespace {

constexpr double kLeastRange = 1e-6;

/// There and back at one rate, the turn `share` of a frame after frame 10.
std::vector<double> there_and_back(double share) {
  std::vector<double> travel;
  for (int f = 0; f <= 20; ++f)
    travel.push_back(0.01 * (10.0 + share - std::abs(f - 10.0 - share)));
  return travel;
}

TEST(LastMotion, ATurnBetweenFramesPartsThemByTheWayTheyLieOn) {
  for (const double share : {0.1, 0.4, 0.6, 0.9}) {
    const std::vector<double> motion = last_motions(there_and_back(share), {}, kLeastRange);
    EXPECT_EQ(motion[10], 1.0) << share;
    EXPECT_EQ(motion[11], -1.0) << share;
  }
}

TEST(LastMotion, OnAFrameItBelongsToTheWayThere) {
  const std::vector<double> motion = last_motions(there_and_back(0.0), {}, kLeastRange);
  EXPECT_EQ(motion[10], 1.0);
  EXPECT_EQ(motion[11], -1.0);
}

TEST(LastMotion, AHoldAtTheTopEndsWithTheFirstStepBackHoweverSmall) {
  std::vector<double> travel;
  for (int f = 0; f <= 20; ++f) travel.push_back(0.01 * f);
  for (int f = 0; f < 20; ++f) travel.push_back(0.2);
  for (int f = 1; f <= 20; ++f) travel.push_back(0.2 - 0.01 * (f - 0.98));  // 0.1 % of the range
  const std::vector<double> motion = last_motions(travel, {}, kLeastRange);
  EXPECT_EQ(motion[40], 1.0);
  EXPECT_EQ(motion[41], -1.0);
}

TEST(LastMotion, NoiseInAHoldIsNoWayBack) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  constexpr double kNoise = 5e-4;
  std::vector<double> travel;
  for (int f = 0; f <= 50; ++f) travel.push_back(0.004 * f + kNoise * normal(engine));
  for (int f = 0; f < 50; ++f) travel.push_back(0.2 + kNoise * normal(engine));
  for (int f = 1; f <= 50; ++f) travel.push_back(0.2 - 0.004 * f + kNoise * normal(engine));
  const std::vector<double> motion = last_motions(travel, {}, kLeastRange);
  for (int f = 0; f <= 95; ++f) EXPECT_EQ(motion[static_cast<std::size_t>(f)], 1.0) << f;
  for (int f = 103; f <= 150; ++f) EXPECT_EQ(motion[static_cast<std::size_t>(f)], -1.0) << f;
}

TEST(LastMotion, WhatBeginsAnewForgetsTheWayBefore) {
  std::vector<double> travel = there_and_back(0.0);  // ends on a way back
  const std::size_t second = travel.size();
  for (const double x : {0.05, 0.06, 0.08}) travel.push_back(x);
  std::vector<bool> starts(travel.size(), false);
  starts[second] = true;
  const std::vector<double> motion = last_motions(travel, starts, kLeastRange);
  EXPECT_EQ(motion[second - 1], -1.0);
  for (std::size_t f = second; f < travel.size(); ++f) EXPECT_EQ(motion[f], 1.0) << f;
}

TEST(LastMotion, NothingMovesWithinTheLeastRange) {
  const std::vector<double> motion = last_motions({0.0, 1e-7, 2e-7, 1e-7}, {}, kLeastRange);
  for (const double m : motion) EXPECT_EQ(m, 0.0);
}

}  // namespace
}  // namespace tenter::estimation
