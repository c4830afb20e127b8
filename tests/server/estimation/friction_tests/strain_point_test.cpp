// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/friction_tests/strain_point.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/estimation/friction_tests/friction_model.h"
#include "tests/server/mechanics/differences.h"
#include "tests/twin/friction/friction_sample.h"

namespace tenter::estimation {
namespace {

using mechanics::PathStatus;

Eigen::VectorXd parameters_of(const twin::FrictionSample& s) {
  Eigen::VectorXd p(static_cast<Eigen::Index>(kFrictionParameters));
  p << s.k1, s.k2, s.a, s.b, 0.0, s.tau;
  return p;
}

/// Where the point rests after each load (N/m).
Eigen::VectorXd rests(const StrainPoint& point, const std::vector<double>& loads,
                      const Eigen::VectorXd& p, mechanics::RowMatrix* by_p = nullptr) {
  StrainPoint::Walk walk;
  point.begin(walk);
  Eigen::VectorXd strains(static_cast<Eigen::Index>(loads.size()));
  if (by_p != nullptr) by_p->resize(strains.size(), p.size());
  for (Eigen::Index i = 0; i < strains.size(); ++i) {
    EXPECT_EQ(point.to_load(loads[static_cast<std::size_t>(i)], p, walk), PathStatus::ok);
    strains[i] = walk.strain;
    if (by_p != nullptr) by_p->row(i) = walk.strain_by_p.transpose();
  }
  return strains;
}

const std::vector<double> kLoads = {1.0, 11.0, 31.0, 25.0, 12.0, 1.0, 22.0, 51.0, 50.0, 0.0};

TEST(StrainPoint, ComesToRestWhereTheTwinsSmallStepsDo) {
  for (const twin::FrictionSample& sample : twin::stretch_samples()) {
    const auto point = StrainPoint::make(friction_model("green_v"));
    ASSERT_TRUE(point);
    const Eigen::VectorXd strains = rests(*point, kLoads, parameters_of(sample));
    testing::Comparison compared(sample.name);
    twin::FrictionState state;
    for (std::size_t i = 0; i < kLoads.size(); ++i) {
      state = twin::moved(sample, state, strains[static_cast<Eigen::Index>(i)]);
      compared.add(kLoads[i], twin::stress(sample, state) * std::sqrt(1.0 + 2.0 * state.strain));
    }
    compared.judge(1e-7);
    EXPECT_GT(strains.maxCoeff(), 0.1);
  }
}

TEST(StrainPoint, KnowsHowItsRestsMoveWithEveryParameter) {
  for (const twin::FrictionSample& sample : twin::stretch_samples()) {
    const auto point = StrainPoint::make(friction_model("green_u"));
    ASSERT_TRUE(point);
    const Eigen::VectorXd p = parameters_of(sample);
    mechanics::RowMatrix by_p;
    rests(*point, kLoads, p, &by_p);
    for (Eigen::Index k = 0; k < p.size(); ++k) {
      const double h = 1e-4 * std::max(std::abs(p[k]), 0.1);
      const auto at = [&](double value) {
        Eigen::VectorXd moved = p;
        moved[k] = value;
        return rests(*point, kLoads, moved);
      };
      const Eigen::VectorXd slope =
          k == kTau ? testing::difference(at, p[k], 1e-3 * p[k]) : testing::difference(at, p[k], h);
      testing::Comparison compared(sample.name + " parameter " + std::to_string(k));
      for (Eigen::Index i = 0; i < slope.size(); ++i) compared.add(by_p(i, k), slope[i]);
      compared.judge(1e-6);
    }
  }
}

TEST(StrainPoint, TakesOneStrainOnly) {
  model::Model model = friction_model("green_v");
  model.terms[1].strain.name = "green_u";
  EXPECT_FALSE(StrainPoint::make(model));
  EXPECT_FALSE(StrainPoint::make(friction_model("green_uv")));
  EXPECT_TRUE(StrainPoint::make(friction_model("bend_v")));
}

TEST(FrictionModel, SaysWhereAStepMayGainWork) {
  EXPECT_EQ(gains_below({135.6, 64.03, 2.22, 3.16, 0.006}), 0.0);
  // table 5.2, paper: b tau = 2 (a + b eps) there
  const FrictionValues paper{479.7e-7, 0.47e-7, 0.04e-4, 0.64e-4, 10.2};
  const double strain = gains_below(paper);
  EXPECT_GT(strain, 1.0);
  EXPECT_NEAR(paper.b * paper.tau, 2.0 * (paper.a + paper.b * strain), 1e-12);
}

}  // namespace
}  // namespace tenter::estimation
