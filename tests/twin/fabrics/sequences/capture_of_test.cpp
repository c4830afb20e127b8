// SPDX-License-Identifier: GPL-3.0-or-later
// A twin that goes through a capture is the sequence that it was.
#include "tests/twin/fabrics/sequences/capture_of.h"

#include <gtest/gtest.h>

#include "common/capture/validate.h"
#include "server/estimation/sequences/from_capture.h"
#include "tests/twin/fabrics/sequences/same_mesh.h"

namespace tenter::twin {
namespace {

/// Measured values by their place in the material.
double seen_at(const estimation::Sequence& sequence, std::size_t frame,
               const Eigen::Vector2d& place, Eigen::Index c) {
  for (std::size_t k = 0; k < sequence.points.size(); ++k)
    if (sequence.points[k].material_m == place)
      return sequence.frames[frame].points_m(c, static_cast<Eigen::Index>(k));
  return std::numeric_limits<double>::quiet_NaN();
}

void expect_the_same_again(const std::string& protocol_name) {
  SCOPED_TRACE(protocol_name);
  const Fabric wool = fabric("18");
  const Protocol protocol = make_protocol(wool, protocol_name, {.frames = 6, .cells = 6});
  auto twin = same_mesh_twin(wool, protocol, {.nodes = 7, .holds_line_beyond_edge = true});
  ASSERT_TRUE(twin) << twin.error().message;
  const estimation::Sequence& before = twin->sequence;
  const capture::Capture capture = capture_of(wool, protocol, before);
  const auto valid = capture::validate(capture);
  ASSERT_TRUE(valid) << valid.error().message;
  const auto made = estimation::sequence_from_capture(capture, {.nodes_u = 7});
  ASSERT_TRUE(made) << made.error().message;
  const estimation::Sequence& after = made->sequence;

  EXPECT_EQ(after.cloth.mesh.triangles, before.cloth.mesh.triangles);
  EXPECT_LT((after.cloth.mesh.material_m - before.cloth.mesh.material_m).norm(), 1e-15);
  EXPECT_LT((after.loads.node_mass_kg - before.loads.node_mass_kg).norm(),
            1e-12 * before.loads.node_mass_kg.norm());
  ASSERT_EQ(after.boundaries.size(), before.boundaries.size());
  ASSERT_EQ(after.forces.size(), before.forces.size());
  ASSERT_EQ(after.frames.size(), before.frames.size());
  double largest_force = 0.0;
  int compared = 0;
  for (std::size_t f = 0; f < after.frames.size(); ++f) {
    const estimation::SequenceFrame& one = before.frames[f];
    const estimation::SequenceFrame& other = after.frames[f];
    EXPECT_EQ(other.block, one.block);
    const auto& held = before.boundaries[static_cast<std::size_t>(one.boundary)];
    const auto& again = after.boundaries[static_cast<std::size_t>(other.boundary)];
    EXPECT_EQ(again.held, held.held);
    ASSERT_EQ(again.clips.size(), held.clips.size());
    for (std::size_t c = 0; c < held.clips.size(); ++c) {
      EXPECT_EQ(again.clips[c].nodes, held.clips[c].nodes);
      EXPECT_LT((other.clips[c].rotation - one.clips[c].rotation).norm(), 1e-12);
      EXPECT_EQ(other.clips[c].position_m, one.clips[c].position_m);
    }
    for (Eigen::Index k = 0; k < one.forces_N.size(); ++k) {
      EXPECT_NEAR(other.forces_N[k], one.forces_N[k], 1e-9);
      largest_force = std::max(largest_force, std::abs(one.forces_N[k]));
    }
    for (std::size_t k = 0; k < after.points.size(); ++k)
      for (Eigen::Index c = 0; c < 3; ++c)
        if (const double value = other.points_m(c, static_cast<Eigen::Index>(k));
            !std::isnan(value)) {
          EXPECT_EQ(value, seen_at(before, f, after.points[k].material_m, c));
          ++compared;
        }
  }
  EXPECT_EQ(compared, made->use.readings);
  EXPECT_GT(compared, 6 * 3 * 10);
  if (!before.forces.empty()) {
    EXPECT_GT(largest_force, 0.01);
  }
}

TEST(CaptureOf, ATwinComesBackFromItsCapture) {
  expect_the_same_again("stretch_u");
  expect_the_same_again("shear");
  expect_the_same_again("bend_v");
}

}  // namespace
}  // namespace tenter::twin
