// SPDX-License-Identifier: GPL-3.0-or-later
// The fabrics are those of the thesis, and the protocols do what their names say.
#include "tests/twin/fabrics/fabric.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "tests/twin/fabrics/protocols.h"

namespace tenter::twin {
namespace {

TEST(Fabric, HasTheRatiosOfTheThesis) {
  const Fabric satin = fabric("4"), knit = fabric("12"), denim = fabric("14"), wool = fabric("18");
  EXPECT_EQ(satin.mass_kg, 1.2e-3);
  EXPECT_EQ(knit.mass_kg, 3.1e-3);
  EXPECT_EQ(denim.mass_kg, 4.6e-3);
  EXPECT_EQ(wool.mass_kg, 2.4e-3);
  EXPECT_DOUBLE_EQ(satin.curve(Mode::stretch_u).largest() / knit.curve(Mode::stretch_u).largest(),
                   250.0);
  double other = 0.0;
  for (const Fabric* cloth : {&satin, &knit, &wool})
    other = std::max(other, cloth->curve(Mode::shear).largest());
  EXPECT_DOUBLE_EQ(denim.curve(Mode::shear).largest() / other, 10.0);
  const auto at_rest = [](const Fabric& cloth, Mode mode) {
    return cloth.curve(mode).stiffness(0.0);
  };
  EXPECT_NEAR(at_rest(denim, Mode::bend_u) / at_rest(denim, Mode::bend_v), 33.0, 1e-9);
  EXPECT_NEAR(at_rest(wool, Mode::bend_u) / at_rest(wool, Mode::bend_v), 13.0, 1e-9);
  EXPECT_NEAR(wool.curve(Mode::stretch_u).largest() / wool.curve(Mode::stretch_v).largest(), 10.0,
              1e-9);
  for (const std::string& id : fabric_ids())
    for (const Loop& loop : fabric(id).loops) {
      EXPECT_GE(loop.ratio, 1.4) << id;
      EXPECT_LE(loop.ratio, 1.8) << id;
    }
}

TEST(Fabric, SecondSpecimensOfKnitAndDenimAreNearTheFirst) {
  const auto disparity = [](const char* id) {
    double sum = 0.0;
    const Fabric first = fabric(id), second = fabric(std::string(id) + ".2");
    for (std::size_t m = 0; m < 3; ++m)
      sum += std::abs(second.curves[m].largest() / first.curves[m].largest() - 1.0) / 3.0;
    return sum;
  };
  EXPECT_GT(disparity("12"), 0.005);
  EXPECT_LT(disparity("12"), 0.05);
  EXPECT_LT(disparity("14"), 0.05);
  EXPECT_GT(disparity("4"), 0.1);
  EXPECT_GT(disparity("18"), 0.1);
}

TEST(StiffnessCurve, StressIsTheSlopeOfTheEnergy) {
  const StiffnessCurve curve = fabric("14").curve(Mode::shear);
  const double size = 0.4 * curve.largest(), h = 1e-6;
  for (double strain = -0.5; strain < 0.5; strain += 0.0313) {
    const CurveValue at = curve.at(strain), up = curve.at(strain + h), down = curve.at(strain - h);
    EXPECT_NEAR((up.energy - down.energy) / (2.0 * h), at.stress, 1e-8 * size) << strain;
    EXPECT_NEAR((up.stress - down.stress) / (2.0 * h), at.tangent, 1e-7 * size / 0.4) << strain;
  }
  EXPECT_EQ(curve.at(0.0).stress, 0.0);
  EXPECT_NEAR(curve.at(0.0).energy, 0.0, 1e-15 * size);
}

TEST(Protocol, HasAsManyFramesAsAskedAndPosesOfEveryClip) {
  for (const std::string& name : protocol_names())
    for (const int frames : {20, 200}) {
      const Protocol p = make_protocol(fabric("18"), name, {.frames = frames});
      ASSERT_EQ(p.frames.size(), static_cast<std::size_t>(frames)) << name;
      for (const ProtocolFrame& frame : p.frames) {
        EXPECT_EQ(frame.poses.size(), p.clips.size());
        EXPECT_EQ(frame.table.has_value(), p.clips.empty());
        for (const ClipPose& pose : frame.poses)
          EXPECT_NEAR(
              (pose.rotation * pose.rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 0.0,
              1e-14);
      }
    }
}

TEST(Protocol, StretchesThreeTimesToTheLimit) {
  const Fabric wool = fabric("18");
  const Protocol p = make_protocol(wool, "stretch_v", {.frames = 120});
  const double free_m = wool.side_m * 22.0 / 24.0;
  double most = 0.0;
  std::set<int> branches;
  for (const ProtocolFrame& frame : p.frames) {
    most = std::max(most, frame.poses[1].position_m.y() / free_m);
    branches.insert(frame.block);
  }
  EXPECT_NEAR(most, wool.limits.stretch_v, 0.04 * wool.limits.stretch_v);
  EXPECT_EQ(branches.size(), 6U);
}

// The bars of the frame stay parallel in pairs, and their directions meet at the angle.
TEST(Protocol, PictureFrameShears) {
  const Fabric cloth = fabric("4");
  const Protocol p = make_protocol(cloth, "shear", {.frames = 200});
  double most = 0.0;
  for (const ProtocolFrame& frame : p.frames) {
    EXPECT_EQ(frame.poses[0].rotation, frame.poses[1].rotation);
    EXPECT_EQ(frame.poses[2].rotation, Eigen::Matrix3d::Identity());
    most = std::max(most, std::abs((frame.poses[0].rotation * p.clips[0].along)
                                       .dot(frame.poses[3].rotation * p.clips[3].along)));
  }
  EXPECT_NEAR(most, cloth.limits.shear, 0.03 * cloth.limits.shear);
}

}  // namespace
}  // namespace tenter::twin
