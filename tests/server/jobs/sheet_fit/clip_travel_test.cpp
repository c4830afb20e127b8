// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sheet_fit/document/clip_travel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tenter::jobs {
namespace {

using Eigen::Vector3d;
using estimation::Sequence;

/// Clips of one node each at `places`, moved by `moved[frame][clip]`.
Sequence clips(const std::vector<Vector3d>& places,
               const std::vector<std::vector<Vector3d>>& moved) {
  Sequence sequence;
  mechanics::Boundary boundary;
  for (const Vector3d& place : places) {
    mechanics::Clip clip;
    clip.id = "c" + std::to_string(boundary.clips.size());
    clip.nodes = {static_cast<int>(boundary.clips.size())};
    clip.place_m = {place};
    boundary.clips.push_back(clip);
  }
  sequence.boundaries = {boundary};
  for (const auto& frame : moved) {
    estimation::SequenceFrame& made = sequence.frames.emplace_back();
    for (const Vector3d& by : frame) made.clips.push_back({Eigen::Matrix3d::Identity(), by});
  }
  return sequence;
}

TEST(ClipTravel, OfTwoClipsIsHowFarTheyWentApartToEitherSide) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
  // taut, sheared by 6 mm, back, by 4 mm to the other side
  const auto to = [&](double way) {
    return std::vector<Vector3d>{-0.5 * way * x + 1e-3 * y, 0.5 * way * x + 1e-3 * y};
  };
  const Sequence sequence = clips({Vector3d::Zero(), y}, {to(0), to(6e-3), to(0), to(-4e-3)});
  for (const std::size_t clip : {0U, 1U}) {
    const ClipTravel travel = clip_travel(sequence, clip);
    const double expected[] = {0.0, 6e-3, 0.0, -4e-3};
    ASSERT_EQ(travel.along_m.size(), 4U);
    for (std::size_t f = 0; f < 4; ++f) EXPECT_NEAR(travel.along_m[f], expected[f], 1e-15);
    EXPECT_EQ(travel.words, "travel between the clips");
  }
}

TEST(ClipTravel, OfCornersUnfoldsWhereAClipWaits) {
  const Vector3d d(std::sqrt(0.5), std::sqrt(0.5), 0.0), e(d.x(), -d.y(), 0.0);
  const auto pulled = [&](double first, double second) {
    return std::vector<Vector3d>{-first * d, first * d, -second * e, second * e};
  };
  // begins with the first diagonal on its way already
  const Sequence sequence = clips({-d, d, -e, e}, {pulled(1e-3, 0), pulled(3e-3, 0), pulled(0, 0),
                                                   pulled(1e-5, 2e-3), pulled(0, 5e-3)});
  const ClipTravel first = clip_travel(sequence, 0);
  const double expected[] = {1e-3, 3e-3, 0.0, -2e-3, -5e-3};
  for (std::size_t f = 0; f < 5; ++f) EXPECT_NEAR(first.along_m[f], expected[f], 1e-15) << f;
  EXPECT_NE(first.words.find("while it waits"), std::string::npos);
  const ClipTravel second = clip_travel(sequence, 3);
  EXPECT_NEAR(second.along_m[1], -3e-3, 1e-15);
  EXPECT_NEAR(second.along_m[4], 5e-3, 1e-15);
}

TEST(ClipTravel, OfAClipThatStaysOrOnlyTurnsIsThatOfTheFarthest) {
  const Vector3d y = Vector3d::UnitY();
  Sequence sequence = clips({-Vector3d::UnitX(), Vector3d::UnitX(), Vector3d::Zero()},
                            {{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()},
                             {Vector3d::Zero(), Vector3d::Zero(), 7e-3 * y},
                             {Vector3d::Zero(), Vector3d::Zero(), -2e-3 * y}});
  // the second one turns about its middle: its pose goes far, its material stays
  const Eigen::Matrix3d turn = mechanics::rotation_of(0.3 * Vector3d::UnitZ());
  sequence.frames[1].clips[1] = {turn, Vector3d::UnitX() - turn * Vector3d::UnitX()};
  ASSERT_GT(sequence.frames[1].clips[1].position_m.norm(), 0.2);
  for (const std::size_t clip : {0U, 1U}) {
    const ClipTravel travel = clip_travel(sequence, clip);
    EXPECT_NEAR(travel.along_m[1], 7e-3, 1e-15);
    EXPECT_NEAR(travel.along_m[2], -2e-3, 1e-15);
    EXPECT_EQ(travel.words, "travel of clip c2");
  }
  EXPECT_EQ(clip_travel(sequence, 2).words, "travel of the clip");
}

}  // namespace
}  // namespace tenter::jobs
