// SPDX-License-Identifier: GPL-3.0-or-later
// The generator itself: sizes reached, noise as declared, captures well formed, everything
// reproducible.
#include "tests/twin/generator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/twin/hidden_effects.h"
#include "tests/twin/machine.h"
#include "tests/twin/noise_chain.h"
#include "tests/twin/sizing.h"
#include "tests/twin/suite.h"

namespace tenter::twin {
namespace {

TEST(TwinGenerator, SuitesAreWellFormed) {
  for (const std::string& suite : suite_names()) {
    SCOPED_TRACE(suite);
    const Expected<Twin> twin = make_twin({.suite = suite, .seed = 3});
    ASSERT_TRUE(twin) << twin.error().message;
    std::size_t frames = 0;
    for (const capture::Capture& capture : twin->captures) {
      SCOPED_TRACE(capture.title);
      const std::size_t count = capture.frame_count();
      frames += count;
      EXPECT_TRUE(capture.provenance.synthetic);
      EXPECT_NE(capture.title.find("SYNTHETIC"), std::string::npos);
      EXPECT_EQ(capture.frame.size(), count);
      EXPECT_EQ(capture.phase.size(), count);
      EXPECT_EQ(capture.branch.size(), count);
      EXPECT_EQ(capture.time_s.size(), suite == "no_time" ? 0U : count);
      for (std::size_t i = 1; i < capture.time_s.size(); ++i)
        EXPECT_LT(capture.time_s[i - 1], capture.time_s[i]);
      std::set<std::string> names;
      for (const capture::Channel& channel : capture.channels) {
        EXPECT_EQ(channel.values.size(), count);
        EXPECT_TRUE(names.insert(channel.name).second);
        for (const double value : channel.values) EXPECT_TRUE(std::isfinite(value));
      }
      ASSERT_FALSE(capture.stresses.empty());
      for (const capture::StressAssignment& stress : capture.stresses)
        EXPECT_NE(capture.find(stress.channel), nullptr);
      std::set<std::string> groups;
      for (const capture::Run& run : capture.runs) groups.insert(run.group);
      EXPECT_LT(groups.size(), capture.runs.size()) << "no repeats";
    }
    EXPECT_GE(frames, suite == "knit_like" ? 200U : 600U);
    EXPECT_LE(frames, 1500U);
  }
}

TEST(TwinGenerator, TheSameCaseGivesTheSameCaptures) {
  const TwinCase twin_case{.effects = {"viscosity"}, .size = 3.0, .seed = 11};
  const Expected<Twin> a = make_twin(twin_case), b = make_twin(twin_case);
  ASSERT_TRUE(a && b);
  for (std::size_t c = 0; c < a->captures.size(); ++c)
    for (std::size_t k = 0; k < a->captures[c].channels.size(); ++k)
      EXPECT_EQ(a->captures[c].channels[k].values, b->captures[c].channels[k].values);
  TwinCase other = twin_case;
  other.seed = 12;
  EXPECT_NE(make_twin(other)->captures[0].channels[1].values, a->captures[0].channels[1].values);
}

TEST(TwinGenerator, EveryEffectReachesItsSize) {
  for (const HiddenEffect& effect : hidden_effects()) {
    // a gain hides in the stiffness of the baseline: only what breaks the symmetry of the coupling
    // is left of it
    // and one free stretch is a small part of what is measured
    const bool small = effect.id == "load_cell_gain" || effect.id == "camera_scale";
    const double largest = small ? 3.0 : 10.0;
    for (const double size : {1.0, 3.0, 10.0}) {
      if (size > largest) continue;
      SCOPED_TRACE(effect.id + " at " + std::to_string(size));
      const std::string suite = effect.needs_specimens ? "specimens" : "rich";
      const Expected<Twin> twin =
          make_twin({.effects = {effect.id}, .size = size, .suite = suite, .seed = 5});
      ASSERT_TRUE(twin) << twin.error().message;
      EXPECT_NEAR(twin->achieved_size / size, 1.0, 0.05)
          << "amplitude " << twin->hidden[0].amplitude;
    }
  }
}

TEST(TwinGenerator, WithoutNoiseAndEffectTheReadingsAreStVenantKirchhoff) {
  const std::vector<PlannedCapture> plans = *plan_suite("rich", Random(1));
  const Cloth cloth;
  const Readings strip = measure(plans[0], 0, cloth, {});
  double peak = 0.0;
  for (std::size_t i = 0; i < strip.stress_x.size(); ++i) {
    const double stretch = 1.0 + plans[0].frames[i].strain_x, e = 0.5 * (stretch * stretch - 1.0);
    EXPECT_NEAR(strip.stress_x[i], stretch * cloth.elastic.c11 * e, 1e-9);
    EXPECT_NEAR(strip.stress_y[i], cloth.elastic.c12 * e, 1e-9);
    peak = std::max(peak, strip.stress_x[i]);
  }
  EXPECT_GT(peak, 40.0);
  // free transverse direction: C12 Eu + C22 Ev = 0
  const Readings free = measure(plans[2], 2, cloth, {});
  EXPECT_TRUE(free.stress_y.empty());
  for (std::size_t i = 0; i < free.stretch_y.size(); ++i) {
    const double stretch = 1.0 + plans[2].frames[i].strain_x, e = 0.5 * (stretch * stretch - 1.0);
    EXPECT_NEAR(free.stretch_y[i], std::sqrt(1.0 - 2.0 * cloth.elastic.c12 / cloth.elastic.c22 * e),
                1e-9);
  }
}

TEST(TwinGenerator, WhatTheBaselineAbsorbsHasNoSize) {
  const std::vector<PlannedCapture> plans = *plan_suite("rich", Random(1));
  Truth plain, stiffer;
  stiffer.cloth.elastic.c11 *= 1.02;
  stiffer.cloth.elastic.c12 *= 1.02;
  EXPECT_LT(Ruler(plans, plain, Baseline::stvk_orthotropic, {}).size_of(stiffer), 0.02);
  EXPECT_GT(Ruler(plans, plain, Baseline::stvk_isotropic, {}).size_of(stiffer), 0.5);
}

// refining the integrator must not move a reading by a visible part of the noise, for effects ten
// times the noise
// also far from the plain cloth, where the tangent there no longer holds
TEST(TwinGenerator, AClothOfTheBaselineHasNoShareOfTheForce) {
  const std::vector<PlannedCapture> plans = *plan_suite("rich", Random(5));
  const Truth plain;
  Truth other = plain;
  other.cloth.elastic.c11 *= 1.7;
  other.cloth.elastic.c12 *= 0.5;
  other.cloth.elastic.c33 *= 1.4;
  EXPECT_LT(Ruler(plans, plain, Baseline::stvk_orthotropic, {}).share_of_force(other), 1e-4);
  EXPECT_GT(Ruler(plans, plain, Baseline::stvk_isotropic, {}).share_of_force(other), 0.02);
}

TEST(TwinGenerator, SmallStepsAreSmallEnough) {
  const std::vector<PlannedCapture> plans = *plan_suite("rich", Random(1));
  Truth truth;
  truth.cloth.friction = {{0.0, 5.0, 40.0, 0.005}, {1.5707963267948966, 5.0, 40.0, 0.005}};
  truth.cloth.maxwell = {200.0, 200.0};
  truth.cloth.relaxation_time_s = 2.0;
  for (const std::size_t c : {std::size_t{0}, std::size_t{2}}) {
    const Readings coarse = measure(plans[c], c, truth.cloth, truth.faults);
    const Readings fine = measure(plans[c], c, truth.cloth, truth.faults, 160);
    double worst = 0.0;
    for (std::size_t i = 0; i < coarse.stress_x.size(); ++i)
      worst = std::max(worst, std::abs(coarse.stress_x[i] - fine.stress_x[i]));
    EXPECT_LT(worst, 0.01);
  }
}

TEST(TwinGenerator, SpecimensDifferByTheirFactorInAllThatTheyShow) {
  std::vector<PlannedCapture> plans = *plan_suite("specimens", Random(1));
  plans[2].frames = plans[0].frames;  // the same instants
  Truth plain, scattered;
  scattered.cloth.specimen_factors = {1.0, 1.25, 0.5};
  const Readings first = measure(plans[0], 0, scattered.cloth, {});
  const Readings second = measure(plans[2], 2, scattered.cloth, {});
  const Readings before = measure(plans[0], 0, plain.cloth, {});
  ASSERT_EQ(plans[2].specimen, 2);
  ASSERT_EQ(plans[2].protocol, plans[0].protocol);
  for (std::size_t i = 0; i < first.stress_x.size(); ++i) {
    EXPECT_EQ(first.stress_x[i], before.stress_x[i]);
    EXPECT_NEAR(second.stress_x[i], 1.25 * first.stress_x[i], 1e-12);
    EXPECT_NEAR(second.stress_y[i], 1.25 * first.stress_y[i], 1e-12);
  }
}

TEST(TwinGenerator, ADelayShiftsTheForceAlongTheClock) {
  const std::vector<PlannedCapture> plans = *plan_suite("single_rate", Random(1));
  Faults faults;
  faults.force_delay_s = 0.5;
  const Readings now = measure(plans[0], 0, Cloth{}, {}),
                 late = measure(plans[0], 0, Cloth{}, faults);
  // third frame of the first pull: rate 0.003 / s, tangent about C11
  const double strain = plans[0].frames[3].strain_x - 0.5 * 0.003;
  const double stretch = 1.0 + strain;
  EXPECT_NEAR(late.stress_x[3], stretch * 600.0 * 0.5 * (stretch * stretch - 1.0), 1e-3);
  EXPECT_LT(late.stress_x[3], now.stress_x[3] - 0.5);
}

TEST(TwinGenerator, AClipSlipsOnceAndInOneRun) {
  const std::vector<PlannedCapture> plans = *plan_suite("rich", Random(1));
  Truth truth;
  find_hidden_effect("clip_slip")->apply(0.01, "", plans, Random(4), truth);
  const Readings plain = measure(plans[0], 0, Cloth{}, {}),
                 slipped = measure(plans[0], 0, truth.cloth, truth.faults);
  std::set<int> runs;
  for (std::size_t i = 0; i < plain.stress_x.size(); ++i)
    if (std::abs(plain.stress_x[i] - slipped.stress_x[i]) > 1e-9) {
      runs.insert(plans[0].frames[i].run);
      EXPECT_GE(i, truth.faults.slip_frame);
    }
  EXPECT_EQ(runs, std::set<int>{truth.faults.slip_run});
}

// cords, caps and cameras turn sound readings into false ones by their own formulas
TEST(TwinGenerator, CordsCapsAndCamerasChangeReadingsAsTheySay) {
  const std::vector<PlannedCapture> plans = *plan_suite("rich", Random(1));
  Faults faults;
  faults.cord_friction = {0.1, 0.0};
  faults.cap_N_m = {1e300, 5.0};
  faults.camera_scale = 1.2;
  const Readings sound = measure(plans[0], 0, Cloth{}, {}),
                 shown = measure(plans[0], 0, Cloth{}, faults);
  int pulled = 0, let_back = 0, capped = 0;
  for (std::size_t i = 1; i < sound.stress_x.size(); ++i) {
    const double travel = plans[0].frames[i].strain_x - plans[0].frames[i - 1].strain_x;
    const double ratio = shown.stress_x[i] / sound.stress_x[i];
    if (travel != 0.0 && sound.stress_x[i] > 1.0) {
      EXPECT_NEAR(ratio, travel > 0.0 ? 1.1 : 0.9, 1e-9);
      ++(travel > 0.0 ? pulled : let_back);
    }
    EXPECT_EQ(shown.stress_y[i], std::min(sound.stress_y[i], 5.0));
    capped += sound.stress_y[i] > 5.0 ? 1 : 0;
  }
  EXPECT_GT(std::min({pulled, let_back, capped}), 20);
  // in a hold the cord stays where its last motion left it
  const auto held = std::find_if(plans[0].frames.begin(), plans[0].frames.end(),
                                 [](const auto& f) { return f.branch == capture::Branch::hold; });
  ASSERT_NE(held, plans[0].frames.end());
  const auto h = static_cast<std::size_t>(held - plans[0].frames.begin());
  EXPECT_NEAR(shown.stress_x[h] / sound.stress_x[h], 1.1, 1e-9);

  const Readings free = measure(plans[2], 2, Cloth{}, {}),
                 seen = measure(plans[2], 2, Cloth{}, faults);
  faults.camera_rest = 0.0;
  const Readings longer = measure(plans[2], 2, Cloth{}, faults);
  double narrowest = 1.0;
  for (std::size_t i = 0; i < free.stretch_y.size(); ++i) {
    EXPECT_NEAR(seen.stretch_y[i] - 1.0, 1.2 * (free.stretch_y[i] - 1.0), 1e-12);
    EXPECT_NEAR(longer.stretch_y[i], 1.2 * free.stretch_y[i], 1e-12);
    narrowest = std::min(narrowest, free.stretch_y[i]);
  }
  EXPECT_LT(narrowest, 0.995);
}

TEST(TwinNoise, TheChainHasTheStandardDeviationItSays) {
  const int runs = 400, length = 50;
  std::vector<int> run;
  std::vector<double> clean;
  for (int r = 0; r < runs; ++r)
    for (int i = 0; i < length; ++i) {
      run.push_back(r);
      clean.push_back(10.0 * i / length);
    }
  std::vector<double> noisy = clean;
  Random random(9);
  const double step = add_noise(NoiseShares{}, 0.2, run, random, noisy);
  EXPECT_GT(step, 0.0);
  double squares = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const double error = noisy[i] - clean[i];
    squares += error * error;
    mean += error;
    EXPECT_NEAR(noisy[i] / step, std::round(noisy[i] / step), 1e-6);
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(clean.size())), 0.2, 0.005);
  EXPECT_NEAR(mean / static_cast<double>(clean.size()), 0.0, 0.01);
}

TEST(TwinGenerator, ADisplayInStepsShowsThemAfterTheNoise) {
  const Expected<Twin> twin =
      make_twin({.effects = {"load_cell_quantisation:x"}, .size = 3.0, .seed = 4});
  ASSERT_TRUE(twin);
  const double step = twin->hidden[0].amplitude;
  // a uniform error of the x cell alone, one cell of about two
  EXPECT_GT(step / std::sqrt(12.0), 3.0 * twin->noise_rms_N_m);
  int shown = 0;
  for (const capture::Capture& capture : twin->captures)
    for (const capture::StressAssignment& stress : capture.stresses) {
      if (stress.component != "x") continue;
      const capture::Channel& channel = *capture.find(stress.channel);
      const double own = channel.unit == "N" ? step * *capture.specimen.width_m : step;
      for (const double value : channel.values)
        EXPECT_NEAR(value / own, std::round(value / own), 1e-6);
      ++shown;
    }
  EXPECT_GE(shown, 4);
}

TEST(TwinGenerator, UnknownNamesAreRefusedBySentence) {
  EXPECT_NE(make_twin({.effects = {"gremlins"}, .size = 3.0}).error().message.find("gremlins"),
            std::string::npos);
  EXPECT_NE(make_twin({.suite = "sweet"}).error().message.find("sweet"), std::string::npos);
  EXPECT_FALSE(make_twin({.effects = {"anisotropy", "poisson_coupling"}, .size = 3.0}));
  EXPECT_FALSE(make_twin({.effects = {"viscosity:treacle"}, .size = 3.0}));
}

TEST(TwinGenerator, TwoEffectsAreEachOfTheSizeAskedFor) {
  const Expected<Twin> twin =
      make_twin({.effects = {"nonlinear_stiffness", "viscosity"}, .size = 3.0, .seed = 2});
  ASSERT_TRUE(twin);
  ASSERT_EQ(twin->hidden.size(), 2U);
  for (const Hidden& hidden : twin->hidden) EXPECT_NEAR(hidden.achieved_size, 3.0, 0.15);
  EXPECT_GT(twin->achieved_size, 3.0);
}

}  // namespace
}  // namespace tenter::twin
