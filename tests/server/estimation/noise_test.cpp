// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/server/estimation/fixtures.h"

namespace tenter::estimation {
namespace {

struct Case {
  std::shared_ptr<DataSet> data;
  std::vector<Row> rows;
  Eigen::VectorXd residuals;
};

/// Residuals of the true model: white noise of `sigma` (SI) on stresses while the data set believes
/// in `believed`.
Case white(const testing::LoopPlan& plan, double sigma, double believed, unsigned seed) {
  Case c;
  c.data = testing::data_of({testing::loop_capture(plan)}, believed);
  c.rows = c.data->rows();
  c.residuals.resize(static_cast<Eigen::Index>(c.rows.size()));
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  for (Eigen::Index r = 0; r < c.residuals.size(); ++r)
    c.residuals[r] = sigma / believed * normal(engine);
  return c;
}

Noise noise_of(const Case& c) {
  return estimate_noise(*c.data, c.rows, c.residuals);
}

TEST(Noise, OfRepeatsIsThatOfTheReadings) {
  double mean = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Noise noise = noise_of(white({.runs = 5, .frames = 60}, 0.3, 1.7, seed));
    ASSERT_EQ(noise.channels[0].size(), 2U);
    for (const ChannelNoise& channel : noise.channels[0]) {
      EXPECT_EQ(channel.source, NoiseSource::repeats);
      EXPECT_NEAR(channel.sigma, 0.3, 0.3 * 0.2);
      EXPECT_NEAR(channel.scatter_sigma, 0.3, 0.3 * 0.2);
      EXPECT_EQ(channel.floor_sigma, channel.repeat_sigma);
      mean += channel.sigma / 40.0;
    }
  }
  EXPECT_NEAR(mean, 0.3, 0.3 * 0.04);
}

TEST(Noise, OfRepeatsDoesNotSeeWhatTheyShare) {
  Case c = white({.runs = 5, .frames = 60}, 0.3, 1.0, 3);
  const double plain = noise_of(c).channels[0][0].sigma;
  for (std::size_t r = 0; r < c.rows.size(); ++r) {
    const double q = c.data->curves[0].path.q[static_cast<std::size_t>(c.rows[r].frame)][0];
    c.residuals[static_cast<Eigen::Index>(r)] += 20.0 * std::sin(40.0 * (q - 1.0));
  }
  EXPECT_NEAR(noise_of(c).channels[0][0].sigma, plain, 0.05 * plain);
  EXPECT_NEAR(noise_of(c).channels[0][0].scatter_sigma, 0.3, 0.3 * 0.2);
}

TEST(Noise, TheFirstOfThreeRunsIsKeptApart) {
  Case c = white({.runs = 4, .frames = 60}, 0.3, 1.0, 3);
  const double plain = noise_of(c).channels[0][0].sigma;
  for (std::size_t r = 0; r < c.rows.size(); ++r)
    if (c.rows[r].frame < 121) c.residuals[static_cast<Eigen::Index>(r)] += 15.0;
  EXPECT_NEAR(noise_of(c).channels[0][0].sigma, plain, 1e-9);
}

TEST(Noise, IsUnbiasedForAnyNumberOfRepeats) {
  // the first run is kept apart: one more is made than repeats count
  for (const int repeats : {3, 4, 5, 8}) {
    double power = 0.0;
    constexpr unsigned kSeeds = 40;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const Noise noise = noise_of(white({.runs = repeats + 1, .frames = 60}, 0.3, 1.7, seed));
      for (const ChannelNoise& channel : noise.channels[0])
        power += channel.repeat_sigma * channel.repeat_sigma / (2.0 * kSeeds);
    }
    // 4,800 (repeats - 1) values of 30 points at least: standard error of the variance below 1.5 %
    EXPECT_NEAR(power, 0.09, 0.09 * 0.045) << repeats << " repeats";
  }
}

TEST(Noise, OneRunsAccidentDoesNotPassForIt) {
  // a slip of so many standard deviations on one branch of one run
  for (const int runs : {4, 5, 6, 9}) {
    for (const double slip : {5.0, 20.0, 100.0}) {
      Case c = white({.runs = runs, .frames = 60}, 0.3, 1.0, 3);
      const Noise plain = noise_of(c);
      for (std::size_t r = 0; r < c.rows.size(); ++r)
        if (c.rows[r].channel == 0 && c.rows[r].frame >= 2 * 121 && c.rows[r].frame < 2 * 121 + 61)
          c.residuals[static_cast<Eigen::Index>(r)] += slip * 0.3;
      const Noise noise = noise_of(c);
      // the run that slipped counts as twice as loud as the others at most, once
      const double sequences = 2.0 * (runs - 1);
      const double most = std::sqrt((sequences + 3.0) / sequences);
      EXPECT_LT(noise.channels[0][0].sigma, 1.08 * most * plain.channels[0][0].sigma)
          << runs << " runs, slip " << slip;
      EXPECT_DOUBLE_EQ(noise.channels[0][1].sigma, plain.channels[0][1].sigma);
      // and the others do not hear it
      int loud = 0;
      for (const auto& sequence : noise.sequences) {
        double power = 0.0;
        for (const double v : sequence) power += v * v / static_cast<double>(sequence.size());
        loud += power > 1.5 * 1.5 ? 1 : 0;
      }
      EXPECT_LE(loud, 1) << runs << " runs, slip " << slip;
    }
  }
}

TEST(Noise, WithoutRepeatsIsTheScatterOfNeighbours) {
  const Noise noise = noise_of(white({.runs = 1, .frames = 200}, 0.3, 2.0, 7));
  EXPECT_EQ(noise.channels[0][0].source, NoiseSource::scatter);
  EXPECT_NEAR(noise.channels[0][0].sigma, 0.3, 0.3 * 0.15);
  EXPECT_EQ(noise.channels[0][0].repeat_sigma, 0.0);
  EXPECT_TRUE(noise.sequences.empty());
}

/// Of two captures of one set-up the one that happens to be smooth does not outweigh the other; one
/// that is pulled along another axis is another specimen, with a noise of its own.
TEST(Noise, OfNeighboursIsPooledOverOneSetUp) {
  constexpr double kRough = 0.3, kSmooth = 0.15;
  for (const double angle_rad : {0.0, 1.0}) {
    Case c;
    c.data = testing::data_of({testing::loop_capture({.runs = 1, .frames = 200}),
                               testing::loop_capture({.runs = 1, .frames = 200})},
                              1.0);
    c.data->curves[1].path.axis_angle_rad = angle_rad;
    c.data->curves[0].runs[0].group = "rough";
    c.data->curves[1].runs[0].group = "smooth";
    c.rows = c.data->rows();
    c.residuals.resize(static_cast<Eigen::Index>(c.rows.size()));
    std::mt19937 engine(11);
    std::normal_distribution<double> normal;
    for (std::size_t r = 0; r < c.rows.size(); ++r)
      c.residuals[static_cast<Eigen::Index>(r)] =
          (c.rows[r].curve == 0 ? kRough : kSmooth) * normal(engine);
    const Noise noise = noise_of(c);
    const double pooled = std::sqrt(0.5 * (kRough * kRough + kSmooth * kSmooth));
    const double expected = angle_rad == 0.0 ? pooled : kSmooth;
    EXPECT_EQ(noise.channels[1][0].source, NoiseSource::scatter);
    EXPECT_NEAR(noise.channels[1][0].sigma, expected, 0.15 * expected);
    EXPECT_NEAR(noise.channels[1][0].scatter_sigma, kSmooth, 0.15 * kSmooth);
  }
}

/// A load cell whose noise grows with the load: what counts is the mean square.
TEST(Noise, OfNeighboursIsTheMeanSquareWhereItGrows) {
  double mean = 0.0, square = 0.0;
  constexpr unsigned kSeeds = 40;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Case c = white({.runs = 1, .frames = 120}, 0.3, 1.0, seed);
    double power = 0.0, rows = 0.0;
    for (std::size_t r = 0; r < c.rows.size(); ++r) {
      if (c.rows[r].channel != 0) continue;
      const double loudness = 0.2 + 1.6 * (c.rows[r].frame % 120) / 120.0;
      c.residuals[static_cast<Eigen::Index>(r)] *= loudness;
      power += 0.09 * loudness * loudness, rows += 1.0;
    }
    const double ratio = noise_of(c).channels[0][0].scatter_sigma / std::sqrt(power / rows);
    mean += ratio / kSeeds;
    square += ratio * ratio / kSeeds;
  }
  EXPECT_NEAR(mean, 1.0, 0.04);  // a median magnitude would be far below
  EXPECT_LT(std::sqrt(square - mean * mean), 0.09);
}

TEST(Noise, DeclaredIsBelievedAndResolutionBoundsIt) {
  Case c = white({.runs = 4, .frames = 60}, 0.3, 1.0, 3);
  c.data->curves[0].channels[0].sigma = 0.25;
  c.data->curves[0].channels[1].resolution = 10.0;
  const Noise noise = noise_of(c);
  EXPECT_EQ(noise.channels[0][0].source, NoiseSource::declared);
  EXPECT_DOUBLE_EQ(noise.channels[0][0].sigma, 0.25);
  EXPECT_DOUBLE_EQ(noise.channels[0][1].sigma, 10.0 / std::sqrt(12.0));
}

TEST(Noise, ItsSequencesAreOfUnitVariance) {
  const Noise noise = noise_of(white({.runs = 6, .frames = 60}, 0.3, 1.7, 5));
  // five repeats of four places: two branches of two channels
  ASSERT_EQ(noise.sequences.size(), 20U);
  double power = 0.0;
  std::size_t count = 0;
  for (const auto& sequence : noise.sequences)
    for (const double v : sequence) {
      power += v * v;
      ++count;
    }
  EXPECT_NEAR(power / static_cast<double>(count), 1.0, 0.05);
}

}  // namespace
}  // namespace tenter::estimation
