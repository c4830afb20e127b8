// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/neighbours.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tenter::diagnosis {
namespace {

constexpr int kFrames = 200;

std::vector<estimation::Row> rows_of_blocks(int blocks) {
  std::vector<estimation::Row> rows;
  for (int f = 0; f < kFrames; ++f) rows.push_back({0, 0, f, f * blocks / kFrames});
  return rows;
}

/// White noise whose loudness grows sevenfold.
Eigen::VectorXd uneven_noise(unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXd noise(kFrames);
  for (int f = 0; f < kFrames; ++f) noise[f] = (0.25 + 1.5 * f / kFrames) * normal(engine);
  return noise;
}

TEST(NeighboursAlike, IsStandardNormalForNoiseThatGrows) {
  double mean = 0.0, square = 0.0;
  constexpr unsigned kSeeds = 400;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const double z = neighbours_alike(rows_of_blocks(2), uneven_noise(seed));
    mean += z / kSeeds, square += z * z / kSeeds;
  }
  EXPECT_NEAR(mean, 0.0, 0.15);
  EXPECT_NEAR(square, 1.0, 0.2);
}

TEST(NeighboursAlike, SeesWhatGoesOnFromOneToTheNext) {
  double mean = 0.0;
  constexpr unsigned kSeeds = 100;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Eigen::VectorXd residuals = uneven_noise(seed);
    for (int f = 0; f < kFrames; ++f) residuals[f] += std::sin(0.1 * f);  // as large as the noise
    mean += neighbours_alike(rows_of_blocks(2), residuals) / kSeeds;
  }
  EXPECT_GT(mean, 3.0);
}

TEST(NeighboursAlike, AreOfOneBlock) {
  const Eigen::VectorXd level = Eigen::VectorXd::Ones(kFrames);
  EXPECT_NEAR(neighbours_alike(rows_of_blocks(1), level), std::sqrt(kFrames - 1.0), 1e-12);
  EXPECT_EQ(neighbours_alike(rows_of_blocks(kFrames), level), 0.0);
}

}  // namespace
}  // namespace tenter::diagnosis
