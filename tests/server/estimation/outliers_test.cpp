// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/outliers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/server/estimation/fixtures.h"

namespace tenter::estimation {
namespace {

struct Readings {
  std::shared_ptr<DataSet> data;
  std::vector<Row> rows;
  Eigen::VectorXd residuals;
};

/// Residuals of unit normal noise over loops, and a smooth misfit of `bias` times the noise that
/// peaks in mid loop.
Readings noisy(unsigned seed, int runs, int frames, double bias) {
  Readings readings;
  readings.data = testing::data_of({testing::loop_capture({.runs = runs, .frames = frames})}, 0.2);
  for (ObservedChannel& channel : readings.data->curves.front().channels)
    for (std::size_t f = 0; f < channel.measured.size(); ++f)
      channel.measured[f] = 600.0 * (readings.data->curves.front().path.q[f][0] - 1.0);
  readings.rows = readings.data->rows();
  readings.residuals.resize(static_cast<Eigen::Index>(readings.rows.size()));
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  for (std::size_t r = 0; r < readings.rows.size(); ++r) {
    const auto f = static_cast<std::size_t>(readings.rows[r].frame);
    const double strain = (readings.data->curves.front().path.q[f][0] - 1.0) / 0.06;
    readings.residuals[static_cast<Eigen::Index>(r)] =
        normal(engine) + bias * std::sin(3.0 * strain);
  }
  return readings;
}

std::size_t count(const Readings& readings) {
  return find_outliers(*readings.data, readings.rows, readings.residuals, {}).size();
}

TEST(Outliers, AreNotFoundInPlainNoise) {
  // 40 data sets of 600 readings each, in long and in short branches: seven standard deviations
  // never happen by chance
  for (const int frames : {12, 20, 60}) {
    std::size_t alarms = 0;
    for (unsigned seed = 1; seed <= 40; ++seed)
      alarms += count(noisy(seed, 150 / frames + 1, frames, 0.0)) > 0 ? 1 : 0;
    EXPECT_LE(alarms, 1U) << "branches of " << frames << " frames";
  }
}

TEST(Outliers, AreNotFoundInASmoothMisfit) {
  for (const double bias : {3.0, 10.0, 30.0}) {
    std::size_t alarms = 0;
    for (unsigned seed = 1; seed <= 20; ++seed)
      alarms += count(noisy(seed, 4, 25, bias)) > 0 ? 1 : 0;
    EXPECT_LE(alarms, 1U) << bias << " times the noise";
  }
}

TEST(Outliers, AreFoundWhereReadingsStandAlone) {
  int found = 0;
  int planted = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Readings readings = noisy(seed, 4, 25, 3.0);
    const std::vector<std::size_t> places = {13, 40, 111, 250};
    for (const std::size_t r : places)
      readings.residuals[static_cast<Eigen::Index>(r)] += r % 2 == 0 ? 15.0 : -15.0;
    const std::vector<Outlier> outliers =
        find_outliers(*readings.data, readings.rows, readings.residuals, {});
    for (const std::size_t r : places) {
      ++planted;
      const auto is_it = [&](const Outlier& o) {
        return o.frame == readings.rows[r].frame && o.channel == readings.rows[r].channel;
      };
      const auto at = std::find_if(outliers.begin(), outliers.end(), is_it);
      if (at == outliers.end()) continue;
      ++found;
      // residuals are predicted minus measured
      EXPECT_EQ(at->deviation < 0.0, r % 2 == 0);
      EXPECT_NEAR(std::abs(at->deviation), 15.0 * 0.2, 0.2 * 5.0);
    }
    EXPECT_LE(outliers.size(), places.size() + 1);
  }
  EXPECT_GE(found, planted * 9 / 10);
}

TEST(Outliers, AStepIsNone) {
  // blocks of channel 0: 0..25 up, 26..50 down, and so on; a step well inside any of them, for
  // good, with and without a smooth misfit
  for (const double bias : {0.0, 10.0}) {
    for (const double step : {-40.0, 15.0, 20.0, 100.0}) {
      for (const int at : {8, 16, 32, 43, 59, 84, 94, 170}) {
        Readings readings = noisy(3, 4, 25, bias);
        for (Eigen::Index r = at; r < 204; ++r) readings.residuals[r] += step;
        EXPECT_EQ(count(readings), 0U) << "step of " << step << " at " << at << ", bias " << bias;
      }
    }
  }
}

TEST(Outliers, AStepInTwoIsNone) {
  for (const double share : {0.3, 0.5, 0.7}) {
    Readings readings = noisy(3, 4, 25, 0.0);
    readings.residuals[43] += 30.0 * share;
    for (Eigen::Index r = 44; r < 204; ++r) readings.residuals[r] += 30.0;
    EXPECT_EQ(count(readings), 0U) << share;
  }
}

TEST(Outliers, AreFoundBesideAStepAndInRows) {
  // one or two eight readings behind a step, three in mid branch
  for (const int length : {1, 2, 3}) {
    int exact = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      Readings readings = noisy(seed, 4, 25, 3.0);
      if (length < 3)
        for (Eigen::Index r = 33; r < 204; ++r) readings.residuals[r] += 20.0;
      for (Eigen::Index r = 41; r < 41 + length; ++r) readings.residuals[r] -= 30.0;
      std::vector<int> frames;
      for (const Outlier& o : find_outliers(*readings.data, readings.rows, readings.residuals, {}))
        frames.push_back(o.frame);
      std::vector<int> planted;
      for (int r = 41; r < 41 + length; ++r)
        planted.push_back(readings.rows[static_cast<std::size_t>(r)].frame);
      exact += frames == planted ? 1 : 0;
    }
    EXPECT_GE(exact, 17) << length << " in a row";
  }
}

}  // namespace
}  // namespace tenter::estimation
