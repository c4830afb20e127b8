// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tenter::diagnosis {
namespace {

/// Ten blocks of twenty frames: a force of 10 N/m and a stretch of 1.1, sigma 0.5 and 0.001.
estimation::DataSet data() {
  estimation::DataSet set;
  estimation::Curves curves;
  estimation::ObservedChannel force;
  force.name = "stress_x";
  estimation::ObservedChannel stretch;
  stretch.name = "stretch_y";
  stretch.is_stress = false;
  stretch.component = 1;
  for (int b = 0; b < 10; ++b) {
    curves.blocks.push_back({0, capture::Branch::load, 20 * b, 20 * b + 20});
    for (int f = 0; f < 20; ++f) {
      curves.path.q.emplace_back(1.0, 1.0, 0.0);
      curves.block_of.push_back(b);
      force.measured.push_back(10.0);
      stretch.measured.push_back(1.1);
    }
  }
  curves.channels = {force, stretch};
  set.left_out = {{std::vector<bool>(200, false), std::vector<bool>(200, false)}};
  set.curves.push_back(std::move(curves));
  set.sigma = {{0.5, 0.001}};
  return set;
}

/// Whitened residuals, one value on forces and one on stretches.
Eigen::VectorXd constant(const std::vector<estimation::Row>& rows, double force, double stretch) {
  Eigen::VectorXd residuals(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t r = 0; r < rows.size(); ++r)
    residuals[static_cast<Eigen::Index>(r)] = rows[r].channel == 0 ? force : stretch;
  return residuals;
}

TEST(ScoreOf, IsTheRelativeErrorOfTheForceAlone) {
  const estimation::DataSet set = data();
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
