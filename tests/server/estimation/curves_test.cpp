// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/estimation/curves.h"
#include "server/estimation/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/base/not_a_number.h"
#include "tests/server/estimation/fixtures.h"

namespace tenter::estimation {
namespace {

using capture::AxisState;
using capture::Quantity;
using testing::loop_capture;
using testing::LoopPlan;

Curves curves_of(const capture::Capture& capture) {
  auto curves = make_curves(capture, "id");
  EXPECT_TRUE(curves) << (curves ? "" : curves.error().message);
  return curves.value_or(Curves());
}

TEST(Curves, RunsBlocksAndChannelsAreThoseOfTheCapture) {
  const Curves curves = curves_of(loop_capture({.runs = 3, .frames = 25}));
  ASSERT_EQ(curves.frame_count(), 3U * 51U);
  ASSERT_EQ(curves.runs.size(), 3U);
  ASSERT_EQ(curves.blocks.size(), 6U);
  ASSERT_EQ(curves.channels.size(), 2U);
  EXPECT_EQ(curves.channels[0].name, "stress_x");
  EXPECT_EQ(curves.channels[1].component, 1);
  EXPECT_EQ(curves.dropped_frames, 0);
  EXPECT_EQ(curves.time_base, TimeBase::clock);
  EXPECT_EQ(curves.blocks[0].branch, capture::Branch::load);
  EXPECT_EQ(curves.blocks[1].branch, capture::Branch::unload);
  for (std::size_t b = 0; b < curves.blocks.size(); ++b) {
    EXPECT_EQ(curves.blocks[b].run, static_cast<int>(b) / 2);
    if (b > 0) {
      EXPECT_EQ(curves.blocks[b].first, curves.blocks[b - 1].last);
    }
    for (int f = curves.blocks[b].first; f < curves.blocks[b].last; ++f)
      EXPECT_EQ(curves.block_of[static_cast<std::size_t>(f)], static_cast<int>(b));
  }
  EXPECT_EQ(curves.runs[0].group, curves.runs[2].group);
  EXPECT_NEAR(curves.path.q[25][0], 1.06, 1e-12);
  EXPECT_NEAR(curves.path.q[25][1], 1.018, 1e-12);
}

TEST(Curves, ForceAndStressBecomeForcePerWidth) {
  capture::Capture capture = loop_capture({.runs = 1});
  for (double& v : capture.channels[2].values) v = 3.0;
  capture.channels[2].sigma = 0.5;
  EXPECT_DOUBLE_EQ(curves_of(capture).channels[0].measured[7], 3.0);
  capture.channels[2].quantity = Quantity::force;
  capture.specimen.width_m = 0.04;
  EXPECT_DOUBLE_EQ(curves_of(capture).channels[0].measured[7], 75.0);
  EXPECT_DOUBLE_EQ(curves_of(capture).channels[0].sigma, 12.5);
  capture.channels[2].quantity = Quantity::stress;
  EXPECT_FALSE(make_curves(capture, "id"));
  capture.specimen.thickness_m = 2e-3;
  EXPECT_DOUBLE_EQ(curves_of(capture).channels[0].measured[7], 6e-3);
}

TEST(Curves, LengthsAndPointsBecomeStretches) {
  const Curves given = curves_of(loop_capture({.runs = 1}));
  capture::Capture by_length = loop_capture({.runs = 1});
  by_length.channels[0].quantity = Quantity::length;
  for (double& v : by_length.channels[0].values) v = 0.1 * (1.0 + v);
  by_length.kinematics.x.reference = AxisState::Reference::first_frame_of_run;
  const Curves lengths = curves_of(by_length);

  capture::Capture by_points = loop_capture({.runs = 1});
  const auto strain = by_points.channels[0].values;
  for (const char* point : {"a", "b"}) {
    capture::Channel channel;
    channel.name = std::string(point) + "_x";
    channel.quantity = Quantity::position;
    channel.point = point;
    channel.coordinate = 'x';
    for (const double e : strain)
      channel.values.push_back(*point == 'a' ? 0.5 : 0.5 + 0.2 * (1.0 + e));
    by_points.channels.push_back(channel);
  }
  by_points.kinematics.x.source = AxisState::Source::points;
  by_points.kinematics.x.point_a = "a";
  by_points.kinematics.x.point_b = "b";
  by_points.kinematics.x.reference = AxisState::Reference::given;
  by_points.kinematics.x.reference_length_m = 0.2;
  const Curves points = curves_of(by_points);
  for (std::size_t f = 0; f < given.frame_count(); ++f) {
    EXPECT_NEAR(lengths.path.q[f][0], given.path.q[f][0], 1e-12);
    EXPECT_NEAR(points.path.q[f][0], given.path.q[f][0], 1e-12);
  }
}

TEST(Curves, FreeStretchesAreObservedAndTheirForceIsNot) {
  const Curves curves = curves_of(loop_capture({.runs = 1, .transverse_free = true}));
  ASSERT_EQ(curves.channels.size(), 2U);
  EXPECT_TRUE(curves.channels[0].is_stress);
  EXPECT_FALSE(curves.channels[1].is_stress);
  EXPECT_EQ(curves.channels[1].name, "stretch_y");
  EXPECT_FALSE(curves.path.is_free[0]);
  EXPECT_TRUE(curves.path.is_free[1]);
}

TEST(Curves, FramesWithoutAStrainAreDroppedAndCountedThoseWithoutAForceAreNot) {
  capture::Capture capture = loop_capture({.runs = 2});
  for (const std::size_t f : {3U, 4U, 60U}) capture.channels[0].values[f] = kNaN;
  capture.channels[2].values[10] = kNaN;
  const Curves curves = curves_of(capture);
  EXPECT_EQ(curves.dropped_frames, 3);
  EXPECT_EQ(curves.frame_count(), 99U);
  EXPECT_EQ(curves.frame[3], 6);
  EXPECT_TRUE(std::isnan(curves.channels[0].measured[8]));
  for (double& v : capture.channels[0].values) v = kNaN;
  EXPECT_FALSE(make_curves(capture, "id"));
}

TEST(Curves, AClockThatRestartsGoesOn) {
  capture::Capture capture = loop_capture({.runs = 3});
  const Curves steady = curves_of(capture);
  for (std::size_t f = 0; f < capture.time_s.size(); ++f)
    capture.time_s[f] = steady.clock_s[f % 51];
  const Curves restarting = curves_of(capture);
  for (std::size_t f = 1; f < restarting.frame_count(); ++f)
    EXPECT_GE(restarting.clock_s[f], restarting.clock_s[f - 1]);
  EXPECT_GT(restarting.clock_s.back(), 2.5 * steady.clock_s[50]);
}

TEST(Curves, WithoutAClockThePathLengthStandsForIt) {
  capture::Capture capture = loop_capture({.runs = 1, .has_time = false});
  EXPECT_EQ(curves_of(capture).time_base, TimeBase::none);
  capture.protocol.nominal_rate_per_s = 0.002;
  const Curves curves = curves_of(capture);
  EXPECT_EQ(curves.time_base, TimeBase::nominal_rate);
  const double length = 0.12 * std::hypot(1.0, 0.3);
  EXPECT_NEAR(curves.clock_s.back(), length / 0.002, 1e-9);
}

TEST(Curves, MemoryGoesOnWhereTheStrainDoes) {
  using mechanics::FrameStart;
  capture::Capture capture = loop_capture({.runs = 2});
  EXPECT_EQ(curves_of(capture).path.start[51], FrameStart::next);
  capture.protocol.history = capture::Protocol::History::virgin_each_run;
  EXPECT_EQ(curves_of(capture).path.start[51], FrameStart::virgin);
  capture.protocol.history = capture::Protocol::History::continues;
  for (std::size_t f = 51; f < 61; ++f) capture.channels[0].values[f] = kNaN;
  EXPECT_EQ(curves_of(capture).path.start[51], FrameStart::rested);
}

std::vector<std::vector<bool>> nothing_left_out(const Curves& curves) {
  return {curves.channels.size(), std::vector<bool>(curves.frame_count(), false)};
}

TEST(Thin, KeepsPathsBlocksAndTime) {
  capture::Capture capture = loop_capture({.runs = 3, .frames = 120});
  for (std::size_t f = 0; f < capture.frame_count(); ++f)
    capture.channels[2].values[f] = 500.0 * capture.channels[0].values[f];
  const Curves full = curves_of(capture);
  const Curves few = thin(full, 20, nothing_left_out(full));
  ASSERT_EQ(few.blocks.size(), full.blocks.size());
  ASSERT_EQ(few.runs.size(), full.runs.size());
  EXPECT_EQ(few.frame_count(), 20U * full.blocks.size());
  EXPECT_EQ(few.runs.back().last, static_cast<int>(few.frame_count()));
  for (std::size_t b = 0; b < full.blocks.size(); ++b) {
    EXPECT_EQ(few.blocks[b].branch, full.blocks[b].branch);
    EXPECT_EQ(few.blocks[b].run, full.blocks[b].run);
    EXPECT_EQ(few.blocks[b].last - few.blocks[b].first, 20);
  }
  for (std::size_t f = 0; f < few.frame_count(); ++f) {
    // on the line of the material, between the frames it stands for
    EXPECT_NEAR(few.channels[0].measured[f], 500.0 * (few.path.q[f][0] - 1.0), 1e-9);
    const auto origin = static_cast<std::size_t>(few.origin[f]);
    EXPECT_EQ(few.frame[f], full.frame[origin]);
    EXPECT_GE(few.clock_s[f], full.clock_s[origin]);
    EXPECT_NEAR(few.path.q[f][0], full.path.q[origin][0], 0.06 / 20.0);
    if (f > 0 && few.path.duration_s[f] > 0.0) {
      EXPECT_NEAR(few.path.duration_s[f], few.clock_s[f] - few.clock_s[f - 1], 1e-9);
    }
  }
  EXPECT_EQ(few.path.start[40], full.path.start[full.runs[1].first]);
}

TEST(Thin, LeavesShortBlocksAlone) {
  const Curves full = curves_of(loop_capture({.runs = 2, .frames = 12}));
  const Curves same = thin(full, 20, nothing_left_out(full));
  ASSERT_EQ(same.frame_count(), full.frame_count());
  for (std::size_t f = 0; f < full.frame_count(); ++f) {
    EXPECT_EQ(same.path.q[f], full.path.q[f]);
    EXPECT_EQ(same.path.duration_s[f], full.path.duration_s[f]);
    EXPECT_EQ(same.channels[0].measured[f], full.channels[0].measured[f]);
  }
}

TEST(Thin, LeavesReadingsOutOfTheMeans) {
  capture::Capture capture = loop_capture({.runs = 1, .frames = 99});
  for (double& v : capture.channels[2].values) v = 4.0;
  capture.channels[2].values[31] = 1000.0;
  const Curves full = curves_of(capture);
  auto left_out = nothing_left_out(full);
  const std::vector<double> spoiled = thin(full, 10, left_out).channels[0].measured;
  EXPECT_GT(*std::max_element(spoiled.begin(), spoiled.end()), 50.0);
  left_out[0][31] = true;
  const std::vector<double> mended = thin(full, 10, left_out).channels[0].measured;
  for (const double v : mended) EXPECT_DOUBLE_EQ(v, 4.0);
  // a whole piece left out is missing
  for (std::size_t f = 30; f < 40; ++f) left_out[0][f] = true;
  const Curves few = thin(full, 10, left_out);
  EXPECT_TRUE(std::isnan(few.channels[0].measured[3]));
  EXPECT_FALSE(std::isnan(few.channels[1].measured[3]));
}

}  // namespace
}  // namespace tenter::estimation
