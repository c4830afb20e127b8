// SPDX-License-Identifier: Apache-2.0
#include "common/experiment/wrinkles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/experiment/settling.h"
#include "common/experiment/wrinkle_measures.h"

namespace tenter::experiment {
namespace {

constexpr int kSide = 41;
constexpr double kLength_m = 0.4;

std::vector<int> square_triangles() {
  std::vector<int> nodes;
  for (int j = 0; j + 1 < kSide; ++j)
    for (int i = 0; i + 1 < kSide; ++i) {
      const int a = j * kSide + i;
      for (const int n : {a, a + 1, a + kSide + 1, a, a + kSide + 1, a + kSide}) nodes.push_back(n);
    }
  return nodes;
}

/// A square whose height is `amplitude` cos(2 pi (x - shift) / length).
std::vector<double> waves(double amplitude_m, double length_m, double shift_m = 0.0) {
  std::vector<double> x;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const double u = kLength_m * i / (kSide - 1), v = kLength_m * j / (kSide - 1);
      x.insert(x.end(),
               {u, v, amplitude_m * std::cos(2.0 * std::numbers::pi * (u - shift_m) / length_m)});
    }
  return x;
}

Wrinkles of(const std::vector<double>& x, double width_m) {
  auto wrinkles = wrinkles_of(square_triangles(), waves(0.0, 1.0), x, width_m);
  EXPECT_TRUE(wrinkles) << wrinkles.error().message;
  return *wrinkles;
}

/// Far from the rim the smoothing leaves exp(-(2 pi width / length)^2 / 2) of a wave.
TEST(Wrinkles, AreWhatSmoothingTakesAway) {
  for (const double width_m : {0.02, 0.04}) {
    const double length_m = 0.1, k = 2.0 * std::numbers::pi / length_m;
    const double share = 1.0 - std::exp(-0.5 * std::pow(k * width_m, 2));
    const Wrinkles wrinkles = of(waves(1e-3, length_m), width_m);
    const auto middle = static_cast<std::size_t>(kSide * (kSide / 2) + kSide / 2);
    EXPECT_NEAR(wrinkles.height_m[middle], 1e-3 * share, 1e-6) << width_m;
  }
  double area = 0.0;
  for (const double a : of(waves(0.0, 1.0), 0.02).area_m2) area += a;
  EXPECT_NEAR(area, kLength_m * kLength_m, 1e-12);
  EXPECT_EQ(height_m(of(waves(0.0, 1.0), 0.02)), 0.0);
  const double rms = height_m(of(waves(1e-3, 0.05), 0.05));
  EXPECT_NEAR(rms, 1e-3 / std::numbers::sqrt2, 0.04e-3);
}

TEST(Wrinkles, AreAlikeWhereTheyAreInPlace) {
  const Wrinkles one = of(waves(1e-3, 0.1), 0.03);
  EXPECT_DOUBLE_EQ(*likeness(one, of(waves(3e-3, 0.1), 0.03)), 1.0);
  EXPECT_DOUBLE_EQ(*likeness(one, of(waves(-1e-3, 0.1), 0.03)), -1.0);
  EXPECT_NEAR(*likeness(one, of(waves(1e-3, 0.1, 0.025), 0.03)), 0.0, 0.01);
  EXPECT_NEAR(*likeness(one, of(waves(1e-3, 0.1, 0.1 / 6.0), 0.03)), 0.5, 0.02);
}

TEST(Wrinkles, AreRefusedWhereTheyMeanNothing) {
  const std::vector<int> triangles = square_triangles();
  const std::vector<double> flat = waves(0.0, 1.0);
  const Wrinkles none = of(flat, 0.02);
  EXPECT_FALSE(likeness(none, none));
  EXPECT_FALSE(likeness(none, {{1.0}, {1.0}}));
  EXPECT_FALSE(wrinkles_of({}, flat, flat, 0.02));
  EXPECT_FALSE(wrinkles_of(triangles, flat, flat, 0.0));
  EXPECT_FALSE(wrinkles_of(triangles, flat, std::vector<double>(3), 0.02));
  EXPECT_FALSE(wrinkles_of({{0, 1, kSide * kSide}}, flat, flat, 0.02));
  EXPECT_FALSE(wrinkles_of(triangles, std::vector<double>(flat.size(), 0.0), flat, 0.02));
  std::vector<double> bad = flat;
  bad[5] = NAN;
  EXPECT_FALSE(wrinkles_of(triangles, flat, bad, 0.02));
}

TEST(Settling, IsTheLastTimeAboveTheBound) {
  const std::vector<double> t = {0.0, 1.0, 2.0, 3.0, 4.0}, v = {0.0, 5.0, 1.0, 3.0, 1.0};
  const auto at = [&](double from, double bound) { return settling(t, v, from, bound); };
  EXPECT_DOUBLE_EQ(at(1.0, 2.0)->time_s, 3.5);  // back above after 2 s
  EXPECT_DOUBLE_EQ(at(1.0, 4.0)->time_s, 1.25);
  EXPECT_DOUBLE_EQ(at(2.0, 4.0)->time_s, 2.0);  // never above from there
  EXPECT_TRUE(at(1.0, 1.0)->is_settled);
  EXPECT_DOUBLE_EQ(at(1.0, 1.0)->time_s, 4.0);
  EXPECT_FALSE(at(1.0, 0.5)->is_settled);
  EXPECT_FALSE(at(5.0, 1.0));
  EXPECT_FALSE(at(0.0, 0.0));
  EXPECT_FALSE(settling(t, std::vector<double>(4), 0.0, 1.0));
  EXPECT_FALSE(settling(std::vector<double>{0.0, 0.0}, std::vector<double>(2), 0.0, 1.0));
}

/// Flat, wavy, wavy elsewhere, wavy as before; moving until the third second.
frames::FrameSet wavy_run() {
  frames::FrameSet run;
  run.nodes = kSide * kSide;
  run.elements = {{"triangle", 3, square_triangles()}};
  run.phases = {"wavy", "elsewhere", "again"};
  run.phase = {-1, 0, 1, 2};
  run.phase_share = {1.0, 1.0, 1.0, 1.0};
  run.time_s = run.kinetic_J = {0.0, 1.0, 2.0, 3.0};
  const double amplitude[] = {0.0, 1e-3, 1e-3, 2e-3}, shift[] = {0.0, 0.0, 0.025, 0.0},
               speed[] = {0.0, 0.3, 0.2, 0.0};
  for (int f = 0; f < 4; ++f) {
    for (const double v : waves(amplitude[f], 0.1, shift[f])) run.position_m.push_back(v);
    for (int n = 0; n < run.nodes; ++n)
      run.velocity_m_s.insert(run.velocity_m_s.end(), {0.6 * speed[f], 0.0, 0.8 * speed[f]});
  }
  run.strains = {{"bend", "bend_u", "hinge", "1/m", {1.0, 3.0}, {{}}},
                 {"friction", "bend_u", "hinge", "1/m", {1.0, 3.0}, {{}}},
                 {"cross", "bend_v", "hinge", "1/m", {4.0, 0.0}, {{}}}};
  for (std::size_t s : {0U, 1U})
    run.strains[s].values[0] = {3.0, 3.0, 9.0, 15.0, 3.0, 3.0, 3.0, 3.0};
  run.strains[2].values[0] = {0.0, 0.0, -6.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  return run;
}

TEST(WrinkleMeasures, AnswerOfTheFramesOfARun) {
  const frames::FrameSet run = wavy_run();
  scene::Measure m;
  m.width_m = 0.03;
  m.at = "wavy";
  // bend_u once: (1 * 2^2 + 3 * 4^2 + 4 * 2^2) / 8
  EXPECT_DOUBLE_EQ(*curvature_change(m, run)->number, std::sqrt(8.5));
  EXPECT_NEAR(*wrinkle_height(m, run)->number, height_m(of(waves(1e-3, 0.1), 0.03)), 1e-15);
  m.like = "again";
  EXPECT_NEAR(*wrinkle_likeness(m, run)->number, 1.0, 1e-12);
  m.like = "elsewhere";
  EXPECT_NEAR(*wrinkle_likeness(m, run)->number, 0.0, 0.01);
  m.like = "start";
  EXPECT_FALSE(wrinkle_likeness(m, run)->number);  // nothing to be like
  m.from = "elsewhere";
  m.bound_m_s = 0.05;
  EXPECT_NEAR(*settling_time(m, run)->number, 0.75, 1e-12);
  m.bound_m_s = 0.5;
  EXPECT_EQ(*settling_time(m, run)->number, 0.0);
  m.from = "never";
  EXPECT_FALSE(settling_time(m, run)->number);
  EXPECT_FALSE(curvature_change(m, run)->number);
  frames::FrameSet still = run;
  still.velocity_m_s.clear();
  still.strains.clear();
  EXPECT_FALSE(settling_time(m, still));
  EXPECT_FALSE(curvature_change(m, still));
}

}  // namespace
}  // namespace tenter::experiment
