// SPDX-License-Identifier: GPL-3.0-or-later
// Readings in steps: the step is found, and said only where it is above the noise.
#include "server/diagnosis/checks/lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/server/diagnosis/prepared_twin.h"

namespace tenter::diagnosis {
namespace {

/// A slow ramp with noise, shown in steps of `step` from an offset.
std::vector<double> ramp(double step, double noise, double offset = 0.0) {
  const Eigen::VectorXd normal = testing::white_noise(300, 7);
  std::vector<double> readings;
  for (int i = 0; i < 300; ++i) {
    const double force = 0.1 * i + noise * normal[i];
    readings.push_back(step > 0.0 ? offset + step * std::round(force / step) : force);
  }
  return readings;
}

TEST(LatticeStep, IsFoundWhereThereIsOne) {
  EXPECT_NEAR(lattice_step(ramp(0.7, 0.3)), 0.7, 1e-9);
  EXPECT_NEAR(lattice_step(ramp(0.7, 0.3, 0.123)), 0.7, 1e-9);
  EXPECT_EQ(lattice_step(ramp(0.0, 0.3)), 0.0);
  // closest readings three and four steps apart
  std::vector<double> sparse;
  for (int i = 0; i < 40; ++i) sparse.push_back(0.5 * (i % 2 == 0 ? 7 * (i / 2) : 7 * (i / 2) + 3));
  EXPECT_NEAR(lattice_step(sparse), 0.5, 1e-9);
}

TEST(LatticeStep, IsNotReadFromTooLittle) {
  EXPECT_EQ(lattice_step({}), 0.0);
  EXPECT_EQ(lattice_step({0.0, 1.0, 2.0, 3.0, 4.0}), 0.0);
  std::vector<double> three_levels;
  for (int i = 0; i < 60; ++i) three_levels.push_back(i % 3);
  EXPECT_EQ(lattice_step(three_levels), 0.0);
  std::vector<double> gaps = ramp(0.7, 0.3);
  gaps[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NEAR(lattice_step(gaps), 0.7, 1e-9);
}

estimation::Curves curves_with(const std::vector<double>& readings) {
  estimation::Curves curves;
  estimation::ObservedChannel channel;
  channel.name = "stress_x";
  channel.measured = readings;
  curves.channels.push_back(channel);
  curves.blocks.push_back({0, capture::Branch::load, 0, static_cast<int>(readings.size())});
  return curves;
}

TEST(Lattices, AreThoseOfTheChannelWhereItMovesOverFewLevels) {
  std::vector<double> still = ramp(0.7, 0.02);
  for (double& v : still) v = v > 20.0 ? 0.7 : 0.0;
  const auto found = find_lattices({curves_with(ramp(0.7, 0.02)), curves_with(still)});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[1].step, 0.7, 1e-9);
  EXPECT_TRUE(find_lattices({curves_with(still)}).empty());
  std::vector<double> off = still;
  off[7] = 0.3;
  EXPECT_EQ(find_lattices({curves_with(ramp(0.7, 0.02)), curves_with(off)}).size(), 1U);
}

TEST(Quantisation, IsSaidWhereStepsAreAboveTheNoise) {
  Diagnosis d;
  d.curves = {curves_with(ramp(0.7, 0.02))};
  const auto coarse = quantisation_verdict(d);
  ASSERT_TRUE(coarse);
  EXPECT_EQ(coarse->kind, VerdictKind::sensor);
  EXPECT_EQ(coarse->effect, "load_cell_quantisation");
  // rms of a ramp from 0 to 30 is 30 / sqrt(3)
  EXPECT_NEAR(coarse->size, 0.7 / std::sqrt(12.0) / (30.0 / std::sqrt(3.0)), 2e-4);
  note_resolution(d.curves);
  EXPECT_NEAR(d.curves[0].channels[0].resolution, 0.7, 1e-9);
  for (const double step : {0.0, 0.2}) {
    d.curves = {curves_with(ramp(step, 0.4))};
    EXPECT_FALSE(quantisation_verdict(d)) << step;
  }
  // the twins' own instruments have steps below their noise
  const Prepared fine = testing::prepared_twin({.suite = "knit_like", .seed = 3});
  d.curves = fine.curves;
  EXPECT_FALSE(find_lattices(d.curves).empty());
  EXPECT_FALSE(quantisation_verdict(d));
}

}  // namespace
}  // namespace tenter::diagnosis
