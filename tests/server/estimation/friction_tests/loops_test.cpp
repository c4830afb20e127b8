// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "server/estimation/friction_tests/bending/cantilever/moment_errors.h"
#include "server/estimation/friction_tests/loops/load_errors.h"
#include "server/estimation/friction_tests/loops/loop_fit.h"
#include "tests/server/estimation/friction_tests/derivatives.h"
#include "tests/twin/friction/friction_sample.h"
#include "tests/twin/friction/hanging_strip.h"

namespace tenter::estimation {
namespace {

/// Up, half of the way back, up again, down below where it began; twice, the second time anew.
LoopTable loops_of_twin(const twin::FrictionSample& cloth) {
  LoopTable table;
  const std::array<double, 5> turns = {0.0, 0.08, 0.04, 0.08, -0.01};
  for (int time = 0; time < 2; ++time) {
    table.beginnings.push_back(static_cast<int>(table.readings.size()));
    twin::FrictionState state;
    for (std::size_t k = 0; k + 1 < turns.size(); ++k) {
      constexpr int kSteps = 25;
      for (int i = 1; i <= kSteps; ++i) {
        const double strain = turns[k] + (turns[k + 1] - turns[k]) * i / kSteps;
        state = twin::moved(cloth, state, strain);
        table.readings.push_back({strain,
                                  twin::stress(cloth, state) * std::sqrt(1.0 + 2.0 * strain),
                                  4 * time + static_cast<int>(k)});
      }
    }
  }
  return table;
}

Eigen::VectorXd near(const twin::FrictionSample& cloth) {
  Eigen::VectorXd p(static_cast<Eigen::Index>(kFrictionParameters));
  p << 1.1 * cloth.k1, cloth.k2, cloth.a, 0.8 * cloth.b, 0.0, 1.2 * cloth.tau;
  return p;
}

TEST(LoadErrors, HaveTheirDerivatives) {
  const twin::FrictionSample& cloth = twin::stretch_samples()[1];
  LoopTable table = loops_of_twin(cloth);
  table.load_noise = 0.01;
  LoadErrors errors(*StrainPoint::make(friction_model("green_u")), table);
  testing::expect_derivatives(errors, near(cloth), {kK1, kK2, kA, kB, kTau});
}

TEST(MomentErrors, HaveTheirDerivatives) {
  const twin::FrictionSample& cloth = twin::bending_samples()[0];
  twin::StripPlan plan;
  plan.clamp_angle_rad = twin::kCantileverAngle;
  plan.length_m = 0.06;
  BendingTests tests;
  tests.area_density_kg_m2 = cloth.density_kg_m2;
  StripTest strip;
  for (const twin::StripPoint& p : twin::photographed(twin::resting_strip(cloth, plan), 1e-4, 3))
    strip.points.push_back({p.x_m, p.y_m});
  strip.length_m = plan.length_m;
  tests.strips.push_back(strip);
  const auto profiles = sampled(tests);
  ASSERT_TRUE(profiles);
  MomentErrors errors(*StrainPoint::make(friction_model("bend_u")),
                      std::make_shared<const std::vector<ProfileSamples>>(*profiles), near(cloth));
  testing::expect_derivatives(errors, near(cloth), {kK1, kK2, kA, kB, kTau});
}

TEST(Loops, WithoutNoiseGiveBackTheTable) {
  const twin::FrictionSample& cloth = twin::stretch_samples()[1];
  const auto found = fit_loops(loops_of_twin(cloth), "green_u", {.profiles = false});
  ASSERT_TRUE(found) << found.error().message;
  const std::array<double, 5> truth = {cloth.k1, cloth.k2, cloth.a, cloth.b, cloth.tau};
  for (std::size_t k = 0; k < truth.size(); ++k)
    EXPECT_NEAR(found->friction.numbers[k].value, truth[k], 1e-3 * truth[k]);
  EXPECT_GT(found->lost_share, 0.1);
  EXPECT_NEAR(found->lost_share, found->lost_share_of_model, 1e-4);
  EXPECT_LT(found->missed_share, 1e-4);
}

TEST(Loops, SayWhatTheyCannotUse) {
  const LoopTable good = loops_of_twin(twin::stretch_samples()[1]);
  ASSERT_TRUE(check(good));
  LoopTable one_way = good;
  one_way.readings.resize(25);
  EXPECT_FALSE(check(one_way));
  LoopTable collapsed = good;
  collapsed.readings[3].strain = -0.6;
  const auto refused = check(collapsed);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("reading 4"), std::string::npos);
  EXPECT_FALSE(fit_loops(good, "bend_u"));
}

}  // namespace
}  // namespace tenter::estimation
