// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/diagnosis/checks/convexity.h"

#include <gtest/gtest.h>

#include "common/model/catalogue.h"
#include "common/model/presets.h"

namespace tenter::diagnosis {
namespace {

/// Equal stretches from rest to 1.05 in eleven frames.
estimation::DataSet biaxial() {
  estimation::DataSet set;
  estimation::Curves curves;
  for (int i = 0; i <= 10; ++i) {
    curves.path.q.emplace_back(1.0 + 0.005 * i, 1.0 + 0.005 * i, 0.0);
    curves.block_of.push_back(0);
  }
  curves.blocks.push_back({0, capture::Branch::load, 0, 11});
  set.curves.push_back(std::move(curves));
  return set;
}

model::Model cloth(double weft, double warp, double coupling) {
  model::Model model = *model::preset("stvk_orthotropic");
  const std::vector<model::Parameter*> p = estimation::parameters_of(model);
  p[0]->value = weft;
  p[1]->value = warp;
  p[2]->value = coupling;
  return model;
}

TEST(Convexity, OfAnOrdinaryClothIsEverywhere) {
  const Convexity found = convexity(cloth(600.0, 800.0, 150.0), biaxial());
  EXPECT_TRUE(found.stable);
  EXPECT_EQ(found.frames, 0);
}

TEST(Convexity, ACouplingBeyondTheMeanOfTheStiffnessesIsNotStable) {
  // at rest the Hessian of the stretches is [[k_u, c], [c, k_v]]: stable where c^2 < k_u k_v
  EXPECT_TRUE(convexity(cloth(400.0, 900.0, 590.0), biaxial()).stable);
  const Convexity found = convexity(cloth(400.0, 900.0, 900.0), biaxial());
  EXPECT_FALSE(found.stable);
  EXPECT_GT(found.frames, 5);
  EXPECT_LE(found.frames, 11);
}

TEST(Convexity, NegativeStiffnessIsNotStable) {
  const Convexity found = convexity(cloth(-100.0, 800.0, 0.0), biaxial());
  EXPECT_FALSE(found.stable);
  EXPECT_EQ(found.frames, 11);
}

TEST(Convexity, ComparesTwoModelsFrameByFrame) {
  const model::Model stable = cloth(600.0, 800.0, 150.0);
  const model::Model run_away = cloth(400.0, 900.0, 900.0);
  const int frames = convexity(run_away, biaxial()).frames;
  ASSERT_GT(frames, 5);
  EXPECT_EQ(frames_made_unstable(stable, run_away, biaxial()), frames);
  EXPECT_EQ(frames_made_unstable(run_away, stable, biaxial()), 0);
  EXPECT_EQ(frames_made_unstable(run_away, run_away, biaxial()), 0);
  // a ten-thousandth of instability is within the slack
  EXPECT_EQ(frames_made_unstable(stable, cloth(-0.08, 800.0, 0.0), biaxial()), 0);
}

TEST(Convexity, WhatRemembersDoesNotCount) {
  model::Model model = cloth(600.0, 800.0, 150.0);
  model::Term set = model.terms.front();
  set.id = "set";
  set.law.name = "plastic_set";
  set.law.parameters = model::default_parameters(*model::find_law("plastic_set"));
  for (model::Parameter& p : set.law.parameters) p.value = p.name == "c" ? 5000.0 : 0.0;
  model.terms.push_back(set);
  EXPECT_TRUE(convexity(model, biaxial()).stable);
}

}  // namespace
}  // namespace tenter::diagnosis
