// SPDX-License-Identifier: Apache-2.0
#include "common/capture/validate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/common/capture/support.h"

namespace tenter::capture {
namespace {

std::string after(const std::function<void(Capture&)>& change) {
  Capture capture = test::small_capture();
  change(capture);
  return test::message_of(validate(capture));
}

TEST(Validate, TakesAGoodCapture) {
  EXPECT_EQ(after([](Capture&) {}), "");
}

TEST(Validate, SizesAgree) {
  EXPECT_EQ(after([](Capture& c) { c.channels[0].values.pop_back(); }),
            "force has 5 values for 6 frames");
  EXPECT_EQ(after([](Capture& c) { c.time_s.pop_back(); }), "time has 5 values for 6 frames");
  EXPECT_EQ(after([](Capture& c) { c.channels[1].sigma_per_frame.pop_back(); }),
            "stretch_x_errors has 5 values for 6 frames");
  EXPECT_EQ(after([](Capture& c) { c.run.clear(); }), "the capture has no frames");
  EXPECT_EQ(after([](Capture& c) { c.channels.clear(); }), "the capture has no channels");
}

TEST(Validate, RunsAndOrder) {
  EXPECT_EQ(after([](Capture& c) { c.run = {0, 1, 0, 1, 1, 1}; }),
            "the frames of run 3 are not in one piece and in order");
  EXPECT_EQ(after([](Capture& c) { c.run = {0, 0, 0, 2, 2, 2}; }),
            "frame at position 3 names run index 2 of 2");
  EXPECT_EQ(after([](Capture& c) { c.runs.push_back({8, ""}); }), "run 8 has no frames");
  EXPECT_EQ(after([](Capture& c) { c.runs[1].number = 3; }), "run number 3 appears twice");
  EXPECT_EQ(after([](Capture& c) { c.time_s[2] = 0.05; }),
            "time does not increase at run 3, frame 9");
  EXPECT_EQ(after([](Capture& c) { c.frame[4] = 1; }),
            "the frame number does not increase at run 7, frame 1");
  EXPECT_EQ(after([](Capture& c) { c.phase[0] = 2; }), "run 3, frame 1 names phase index 2 of 2");
}

TEST(Validate, Channels) {
  EXPECT_EQ(after([](Capture& c) { c.channels[0].unit = "kN"; }),
            "channel \"force\" has unit \"kN\"; a force is kept in \"N\"");
  EXPECT_EQ(after([](Capture& c) { c.channels[0].name = "a b"; }),
            "channel \"a b\": a name has only letters, digits and \"_\"");
  EXPECT_EQ(after([](Capture& c) { c.channels[2].name = "time"; }),
            "channel \"time\": this name is reserved");
  EXPECT_EQ(after([](Capture& c) { c.channels[2].name = "force"; }),
            "channel \"force\" appears twice");
  EXPECT_EQ(
      after([](Capture& c) { c.channels[2].may_be_missing = false; }),
      "channel \"humidity\" has no value at run 3, frame 9 and does not declare missing values");
  EXPECT_EQ(
      after([](Capture& c) { c.channels[0].values[1] = std::numeric_limits<double>::infinity(); }),
      "channel \"force\" is infinite at run 3, frame 5");
  EXPECT_EQ(after([](Capture& c) { c.channels[0].sigma = -1; }),
            "channel \"force\" has a negative or unusable sigma");
  EXPECT_EQ(
      after([](Capture& c) { c.channels[1].sigma_per_frame[0] = std::nan(""); }),
      "channel \"stretch_x\" has a negative or unusable standard deviation at run 3, frame 1");
  EXPECT_EQ(after([](Capture& c) { c.channels[3].point = ""; }),
            "channel \"left_x\" is a position and must name its point and coordinate x, y or z");
  EXPECT_EQ(after([](Capture& c) { c.channels[4].coordinate = 'x'; }),
            "channel \"left_y\": coordinate x of point \"left\" appears twice");
}

TEST(Validate, SpecimenProtocolAndTexts) {
  EXPECT_EQ(after([](Capture& c) { c.specimen.width_m = -1.0; }),
            "specimen.width must be positive, not -1.000000");
  EXPECT_EQ(after([](Capture& c) { c.specimen.thickness_m = 0.0; }),
            "specimen.thickness must be positive, not 0.000000");
  EXPECT_EQ(after([](Capture& c) { c.protocol.nominal_rate_per_s = 0.0; }),
            "protocol.nominal_rate_per_s must be positive");
  EXPECT_EQ(after([](Capture& c) { c.protocol.phases[1].name = "pull"; }),
            "phase \"pull\" appears twice");
  EXPECT_EQ(after([](Capture& c) { c.protocol.phases[1].kind = "jump"; }),
            "phase \"rest\" has kind \"jump\", not one of ramp, cycle, hold, step, other");
  EXPECT_EQ(after([](Capture& c) { c.kind = "song"; }),
            "kind \"song\" is not one of homogeneous_strain, tracked_points, deforming_sheet, "
            "strip_profiles");
  EXPECT_EQ(after([](Capture& c) { c.title = "\x1b[31mred"; }), "title holds a control character");
  EXPECT_EQ(after([](Capture& c) { c.title = "\xff"; }), "title is not valid UTF-8");
  EXPECT_EQ(after([](Capture& c) { c.title = "\xC0\xAF"; }), "title is not valid UTF-8");
  EXPECT_EQ(after([](Capture& c) { c.title = "\xED\xA0\x80"; }), "title is not valid UTF-8");
  EXPECT_EQ(after([](Capture& c) { c.runs[0].group = "\xE2\x82"; }),
            "the group of run 3 is not valid UTF-8");
  EXPECT_EQ(after([](Capture& c) { c.specimen.name.assign(40000, 'x'); }),
            "specimen.name is longer than 32000 bytes");
}

TEST(Validate, KinematicsAndStresses) {
  EXPECT_EQ(after([](Capture& c) { c.kinematics.x.channel = "nothing"; }),
            "kinematics.x names channel \"nothing\", which is not there");
  EXPECT_EQ(after([](Capture& c) { c.kinematics.y.point_b = "left"; }),
            "kinematics.y names point \"left\" twice");
  EXPECT_EQ(after([](Capture& c) { c.kinematics.y.point_b = "middle"; }),
            "kinematics.y names point \"middle\", which has no two position channels");
  EXPECT_EQ(after([](Capture& c) { c.kinematics.x.source = AxisState::Source::none; }),
            "kinematics.x is prescribed and must name a channel or two points");
  EXPECT_EQ(after([](Capture& c) { c.kinematics.y.role = AxisState::Role::free; }),
            "kinematics.y is free and must not name a channel or points");
  EXPECT_EQ(after([](Capture& c) { c.kinematics.xy = c.kinematics.x; }),
            "kinematics.xy names channel \"stretch_x\", which measures stretch, not shear");
  EXPECT_EQ(
      after([](Capture& c) { c.stresses[0].channel = "stretch_x"; }),
      "stresses.x names channel \"stretch_x\", which measures stretch, not a force or stress");
  EXPECT_EQ(after([](Capture& c) { c.stresses.push_back(c.stresses[0]); }),
            "stresses.x appears twice");
  EXPECT_EQ(after([](Capture& c) { c.specimen.width_m.reset(); }),
            "stresses.x: the force \"force\" needs specimen.width or specimen.cross_section");
}

}  // namespace
}  // namespace tenter::capture
