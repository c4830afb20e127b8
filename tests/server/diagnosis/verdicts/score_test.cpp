// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/verdicts/score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/server/diagnosis/two_channels.h"

namespace tenter::diagnosis {
namespace {

/// Whitened residuals, one value on forces and one on stretches.
Eigen::VectorXd constant(const std::vector<estimation::Row>& rows, double force, double stretch) {
  Eigen::VectorXd residuals(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t r = 0; r < rows.size(); ++r)
    residuals[static_cast<Eigen::Index>(r)] = rows[r].channel == 0 ? force : stretch;
  return residuals;
}

TEST(ScoreOf, IsTheRelativeErrorOfTheForceAlone) {
  const estimation::DataSet set = two_channels(10, 20);
  const auto rows = set.rows();
  EXPECT_NEAR(score_of(set, rows, constant(rows, 2.0, 99.0), -1).error, 0.1, 1e-12);
  EXPECT_NEAR(score_of(set, rows, constant(rows, 2.0, 99.0), 0).error, 0.1, 1e-12);
  Eigen::VectorXd partly = constant(rows, 2.0, 0.0);
  for (Eigen::Index r = 0; r < 100; ++r) partly[r] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NEAR(score_of(set, rows, partly, -1).error, 0.1, 1e-12);
  estimation::Noise noise;
  noise.channels = {{{}, {}}};
  noise.channels[0][0].floor_sigma = 0.3;
  EXPECT_NEAR(noise_floor_of(set, rows, noise, -1), 0.03, 1e-12);
}

}  // namespace
}  // namespace tenter::diagnosis
